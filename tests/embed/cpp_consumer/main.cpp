// Prints the neighbors of four seeds in a row. Returns 1 if they are wrong.
#include <cmath>
#include <cstdint>
#include <iostream>
#include <vector>
#include <votess/votess.hpp>

int main() {
    const std::vector<double> points = {0.5, 0.5, 0.5, 1.5, 0.5, 0.5, 2.5, 0.5, 0.5, 3.5, 0.5, 0.5};
    const std::vector<std::vector<std::int32_t>> expected = {{1}, {0, 2}, {1, 3}, {2}};

    votess::Options options;
    options.box = votess::Box{{0, 0, 0}, {4, 1, 1}};
    votess::Tessellation t;
    try {
        t = votess::tessellate(points, options);
    } catch (const votess::Error& error) {
        std::cerr << "cpp_consumer: " << error.what() << '\n';
        return 1;
    }

    bool right = t.size() == expected.size();
    for (std::size_t i = 0; right && i < t.size(); ++i) {
        std::cout << i << ':';
        std::vector<std::int32_t> row;
        for (auto j : t.neighbors(i)) {
            std::cout << ' ' << j;
            row.push_back(j);
        }
        std::cout << '\n';
        right = row == expected[i] && std::abs(t.volumes()[i] - 1) < 1e-13;
    }
    if (!right) std::cerr << "cpp_consumer: wrong answer\n";

    // The program can catch the library's exceptions by type.
    options.threads = 100000;
    try {
        t = votess::tessellate(points, options);
        std::cerr << "cpp_consumer: 100000 threads were accepted\n";
        right = false;
    } catch (const votess::Error& error) {
        right = right && error.code() == votess::ErrorCode::invalid_argument;
    }
    return right ? 0 : 1;
}
