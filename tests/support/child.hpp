// What a test does in a child made by fork().
#pragma once

#include <functional>
#include <string>

namespace test {

// What went wrong there, "" when nothing: what `work` returned or threw, or how the child ended. One that hangs is
// ended after a minute.
std::string in_child(const std::function<std::string()>& work);

}  // namespace test
