#include "files/text_source.hpp"

#include <algorithm>
#include <utility>

#include "failure.hpp"
#include "files/limits.hpp"

namespace clvotess {
namespace {

constexpr std::size_t text_piece = std::size_t{1} << 20;

}  // namespace

TextSource::TextSource(const std::string& path, bool packed) : file_(std::in_place, path) {
    name_ = file_->name();
    if (packed) inflater_.emplace(std::string_view(), Inflater::Frame::gzip);
}

TextSource::TextSource(std::string_view text, std::string name) : name_(std::move(name)), text_(text) {}

bool TextSource::append(std::string& to) {
    if (inflater_) return append_unpacked(to);
    if (!file_) {
        const std::size_t size = std::min(text_.size(), text_piece);
        to.append(text_.substr(0, size));
        text_.remove_prefix(size);
        return !text_.empty();
    }
    const std::size_t before = to.size();
    more_ = more_ && file_->append(to, text_piece);
    read_ += to.size() - before;
    return more_;
}

bool TextSource::append_unpacked(std::string& to) {
    const std::size_t before = to.size();
    to.resize(before + text_piece);
    std::size_t used = before;
    const auto failure = [&](bool early) {
        return bad_input(name_ +
                         (early ? ": the file ends too early" : ": not a file packed by gzip, or a damaged one"));
    };
    while (used < to.size()) {
        if (!inflater_->has_more()) {
            packed_.clear();
            if (more_) more_ = file_->append(packed_, text_piece);
            read_ += packed_.size();
            if (packed_.empty()) {
                if (!more_ && (begun_ || read_ == 0)) throw failure(true);
                break;
            }
            inflater_->go_on(packed_);
        }
        if (inflater_->ended()) inflater_->restart();
        begun_ = true;
        used += inflater_->read(to.data() + used, to.size() - used);
        if (inflater_->damaged()) throw failure(false);
        begun_ = !inflater_->ended();
    }
    unpacked_ += used - before;
    to.resize(used);
    check_unpacked(file_->is_regular() ? file_->size() : read_, unpacked_, name_);
    return more_ || inflater_->has_more() || begun_;
}

double TextSource::fraction() const noexcept {
    return file_ && file_->size() > 0 ? static_cast<double>(read_) / static_cast<double>(file_->size()) : 0;
}

std::optional<std::uint64_t> TextSource::rest() const noexcept {
    if (inflater_) return std::nullopt;
    if (!file_) return text_.size();
    if (!file_->is_regular()) return std::nullopt;
    return file_->size() - std::min(file_->size(), read_);
}

std::string rest_of(TextSource& source, std::string begun) {
    // One byte more than expected, so that the end shows without another read.
    begun.reserve(begun.size() + static_cast<std::size_t>(source.rest().value_or(0)) + 1);
    bool more = true;
    while (more) {
        const std::size_t before = begun.size();
        more = source.append(begun);
        check_last_line(std::string_view(begun).substr(before - std::min(before, max_line + 1)), source.name());
    }
    return begun;
}

}  // namespace clvotess
