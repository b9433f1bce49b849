// A file that all ranks write. It appears whole or not at all.
#pragma once

#include <optional>
#include <string>

#include "files/output_file.hpp"
#include "mpi/ranks.hpp"

namespace clvotess {

// One at a time. All ranks open the temporary file by its name. A rank that gets a signal removes it; mpirun sends one
// when another rank has died. The file remains when all ranks are killed at once.
class SharedFile {
public:
    // Collective. Rank 0 creates the temporary file, which the others must see under the same name.
    SharedFile(const Ranks& ranks, const std::string& path);
    ~SharedFile();
    SharedFile(const SharedFile&) = delete;
    SharedFile& operator=(const SharedFile&) = delete;

    [[nodiscard]] const std::string& temporary() const noexcept { return temporary_; }
    [[nodiscard]] Failure write_failure(int error) const;
    // Collective. Gives the file its name.
    void publish();

private:
    const Ranks& ranks_;
    std::string name_, temporary_;
    std::optional<OutputFile> file_;  // on rank 0
};

}  // namespace clvotess
