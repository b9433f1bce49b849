#pragma once

#include <functional>

namespace test {

// Makes the call after the last test, before globals are destroyed.
void at_end(std::function<void()> call);

}  // namespace test
