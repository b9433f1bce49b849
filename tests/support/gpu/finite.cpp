#include "support/gpu/finite.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <initializer_list>
#include <map>
#include <set>
#include <stdexcept>
#include <string>

namespace test {

namespace {

using Words = std::span<const std::uint32_t>;

// Numbers of the SPIR-V specification.
enum Operation : std::uint32_t {
    op_ext_inst_import = 11,
    op_ext_inst = 12,
    op_type_bool = 20,
    op_type_float = 22,
    op_type_vector = 23,
    op_type_pointer = 32,
    op_constant = 43,
    op_constant_composite = 44,
    op_function = 54,
    op_variable = 59,
    op_load = 61,
    op_access_chain = 65,
    op_decorate = 71,
    op_bitcast = 124,
    op_is_nan = 156,
    op_is_inf = 157,
    op_select = 169,
    op_f_ord_less_than_equal = 188
};
enum Extended : std::uint32_t { f_abs = 4, n_clamp = 81 };
constexpr std::uint32_t header_words = 5, bound = 3;  // the place of the bound of ids

bool computes(std::uint32_t operation) {
    static const std::set<std::uint32_t> all{op_ext_inst, op_bitcast,
                                             115,   // FConvert
                                             129,   // FAdd
                                             131,   // FSub
                                             133,   // FMul
                                             136,   // FDiv
                                             140,   // FRem
                                             141,   // FMod
                                             142,   // VectorTimesScalar
                                             145,   // MatrixTimesVector
                                             148,   // Dot
                                             350};  // GroupNonUniformFAdd
    return all.contains(operation);
}

template <class Each>
void for_each(Words spirv, Each each) {
    for (std::size_t at = header_words; at < spirv.size(); at += spirv[at] >> 16)
        each(spirv[at] & 0xffffu, spirv.subspan(at, spirv[at] >> 16));
}

struct Type {
    std::uint32_t width = 0, components = 1;  // of floats; width 0: bool
    auto operator<=>(const Type&) const = default;
};

class Rewriter {
public:
    Rewriter(Words spirv, Instead instead) : spirv_(spirv), instead_(instead), next_(spirv[bound]) { read(); }

    std::vector<std::uint32_t> rewritten() {
        out_.assign(spirv_.begin(), spirv_.begin() + header_words);
        bool in_functions = false;
        for_each(spirv_, [&](std::uint32_t operation, Words words) {
            if (operation == op_function && !in_functions) {
                in_functions = true;
                declare();
            }
            const std::size_t begin = out_.size();
            out_.insert(out_.end(), words.begin(), words.end());
            if (operation == op_decorate) {
                const auto found = raw_.find(words[1]);
                if (found != raw_.end()) out_[begin + 1] = found->second;  // of the operation
            } else if (in_functions && words.size() > 2) {
                const auto found = raw_.find(words[2]);
                if (found == raw_.end() || !changes(operation, words)) return;
                out_[begin + 2] = found->second;
                append_change(words[1], words[2], found->second);
            }
        });
        out_[bound] = next_;
        return out_;
    }

private:
    // Collects the types, and gives new ids to results that change.
    void read() {
        for_each(spirv_, [&](std::uint32_t operation, Words words) {
            switch (operation) {
                case op_ext_inst_import:
                    if (std::strcmp(reinterpret_cast<const char*>(&words[2]), "GLSL.std.450") == 0) import_ = words[1];
                    break;
                case op_type_bool:
                    types_[words[1]] = {0, 1};
                    break;
                case op_type_float:
                    types_[words[1]] = {words[2], 1};
                    break;
                case op_type_vector:
                    if (types_.contains(words[2])) types_[words[1]] = {types_[words[2]].width, words[3]};
                    break;
                case op_type_pointer:
                    storage_[words[1]] = words[2];
                    break;
                case op_variable:
                case op_access_chain:
                    pointers_[words[2]] = storage_[words[1]];
                    break;
                default:
                    break;
            }
            if (changes(operation, words)) raw_[words[2]] = next_++;
        });
        if (import_ == 0) throw std::runtime_error("a module without GLSL.std.450");
    }

    [[nodiscard]] bool changes(std::uint32_t operation, Words words) const {
        if (!computes(operation) && operation != op_load) return false;
        const auto found = types_.find(words[1]);
        if (found == types_.end() || found->second.width == 0) return false;
        if (operation != op_load) return true;
        // Memory of functions and invocations holds results, which are finite already.
        constexpr std::uint32_t of_work_group = 4, of_buffer = 12;
        const auto pointer = pointers_.find(words[3]);
        return pointer != pointers_.end() && (pointer->second == of_work_group || pointer->second == of_buffer);
    }

    void append(std::uint32_t operation, std::initializer_list<std::uint32_t> operands) {
        out_.push_back(static_cast<std::uint32_t>(operands.size() + 1) << 16 | operation);
        out_.insert(out_.end(), operands);
    }
    // Returns the id of a type; declares it if need be.
    std::uint32_t id_of(Type type) {
        for (const auto& [id, known] : types_)
            if (known == type) return id;
        const std::uint32_t scalar = type.components > 1 ? id_of({type.width, 1}) : 0, id = next_++;
        if (type.components > 1)
            append(op_type_vector, {id, scalar, type.components});
        else
            append(op_type_bool, {id});
        types_[id] = type;
        return id;
    }
    // Declares constants of a type of floats: minus the largest number, the largest, 0.
    void declare(std::uint32_t id, Type type) {
        std::array<std::uint32_t, 3>& all = constants_[id];
        const std::uint32_t scalar = id_of({type.width, 1});
        if (type.components > 1 && !constants_.contains(scalar)) declare(scalar, {type.width, 1});
        for (std::size_t i = 0; i < 3; ++i) {
            all[i] = next_++;
            if (type.components > 1) {
                out_.push_back((type.components + 3) << 16 | op_constant_composite);
                out_.insert(out_.end(), {id, all[i]});
                out_.insert(out_.end(), type.components, constants_[scalar][i]);
            } else if (type.width == 32) {
                append(op_constant, {id, all[i], std::array{0xff7fffffu, 0x7f7fffffu, 0u}[i]});
            } else {
                append(op_constant, {id, all[i], i < 2 ? ~0u : 0u, std::array{0xffefffffu, 0x7fefffffu, 0u}[i]});
            }
        }
    }
    void declare() {
        for (const auto& [id, type] : std::map(types_)) {
            if (type.width == 0) continue;
            if (!constants_.contains(id)) declare(id, type);
            id_of({0, type.components});
        }
    }
    void append_change(std::uint32_t type, std::uint32_t id, std::uint32_t raw) {
        const auto& [lowest, largest, zero] = constants_[type];
        if (instead_ == Instead::largest)
            return append(op_ext_inst, {type, id, import_, n_clamp, raw, lowest, largest});
        const std::uint32_t size = next_++, finite = next_++;
        append(op_ext_inst, {type, size, import_, f_abs, raw});
        append(op_f_ord_less_than_equal, {id_of({0, types_[type].components}), finite, size, largest});
        append(op_select, {type, id, finite, raw, zero});
    }

    Words spirv_;
    Instead instead_;
    std::uint32_t next_, import_ = 0;
    std::vector<std::uint32_t> out_;
    std::map<std::uint32_t, Type> types_;
    std::map<std::uint32_t, std::uint32_t> storage_, pointers_;  // storage classes of types, of pointers
    std::map<std::uint32_t, std::uint32_t> raw_;                 // new ids of results
    std::map<std::uint32_t, std::array<std::uint32_t, 3>> constants_;
};

}  // namespace

std::vector<std::uint32_t> with_finite_results(Words spirv, Instead instead) {
    return Rewriter(spirv, instead).rewritten();
}

bool mentions_infinity(Words spirv) {
    std::map<std::uint32_t, std::uint32_t> widths;
    bool found = false;
    for_each(spirv, [&](std::uint32_t operation, Words words) {
        if (operation == op_type_float) widths[words[1]] = words[2];
        found = found || operation == op_is_nan || operation == op_is_inf;
        if (operation != op_constant || !widths.contains(words[1])) return;
        const std::uint32_t exponent = widths[words[1]] == 32 ? 0x7f800000u : 0x7ff00000u;
        found = found || (words.back() & exponent) == exponent;
    });
    return found;
}

}  // namespace test
