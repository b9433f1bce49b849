// A file or stdin, read front to back through memory of its own: pages of a mapped file count as memory in use.
#pragma once

#include <string>

namespace clvotess {

class SequentialFile {
public:
    explicit SequentialFile(const std::string& path);  // "-" is stdin. Throws Failure
    SequentialFile(const SequentialFile&) = delete;
    SequentialFile& operator=(const SequentialFile&) = delete;
    ~SequentialFile();

    // Adds the next bytes, so many if there are; false at the end.
    bool append(std::string& to, std::size_t bytes);

private:
    std::string path_;
    int descriptor_;
};

}  // namespace clvotess
