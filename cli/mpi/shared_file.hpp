// A file that all ranks write, which appears whole or not at all.
#pragma once

#include <optional>
#include <string>

#include "files/output_file.hpp"
#include "mpi/ranks.hpp"

namespace clvotess {

// One at a time. The temporary file has a name, by which all ranks open it. A rank that gets a signal, as mpirun sends
// when another rank has died, removes it; it stays when all ranks are killed at once.
class SharedFile {
public:
    // Collective. Rank 0 makes the temporary file, which the others must see under the same name.
    SharedFile(const Ranks& ranks, const std::string& path);
    ~SharedFile();
    SharedFile(const SharedFile&) = delete;
    SharedFile& operator=(const SharedFile&) = delete;

    [[nodiscard]] const std::string& temporary() const noexcept { return temporary_; }
    [[nodiscard]] Failure write_failure(int error) const;
    // Collective: the file appears under its name.
    void publish();

private:
    const Ranks& ranks_;
    std::string name_, temporary_;
    std::optional<OutputFile> file_;  // of rank 0
};

}  // namespace clvotess
