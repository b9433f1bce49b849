#include "picture/legend/text.hpp"

#include <array>
#include <cmath>
#include <string_view>

namespace votess::picture {
namespace {

// On a grid of whole numbers: the baseline is at height 0, x reaches 7, capitals 10, tails -3. Words are strokes: their
// kind (l = lines, s = smooth, o = smooth and closed), then points as a digit for x and a letter for y, d = 0, n = 10.
// Smooth strokes are quadratic B-splines: they touch the middles of the sides of their points' polygon.
struct Glyph {
    int width;
    std::string_view strokes;
};

constexpr std::array<Glyph, 95> glyphs{{
    {2, ""},                                   // space
    {0, "l0n0g l0d0d"},                        // !
    {2, "l0n0l l2n2l"},                        // "
    {6, "l1d2n l4d5n l0g6g l0k6k"},            // #
    {6, "s6l6n0n0i6i6d0d0f l3o3c"},            // $
    {7, "o0n3n3j0j o4h7h7d4d l6n1d"},          // %
    {6, "s6d1k1n4n4k0g0d4d6h"},                // &
    {0, "l0n0l"},                              // '
    {2, "s2o0l0e2b"},                          // (
    {2, "s0o2l2e0b"},                          // )
    {4, "l0e4i l0i4e"},                        // * as a sign of multiplication
    {6, "l0h6h l3e3k"},                        // +
    {1, "l1d0b"},                              // ,
    {4, "l0h4h"},                              // -
    {0, "l0d0d"},                              // .
    {4, "l0c4n"},                              // /
    {6, "o0n6n6d0d"},                          // 0
    {6, "l1l3n3d"},                            // 1
    {6, "s0k0n6n6i0d l0d6d"},                  // 2
    {6, "s0l0n6n5i2i s2i6i6d0d0f"},            // 3
    {6, "l4d4n0g6g"},                          // 4
    {6, "l5n1n0i s0i2k6k6d1d0f"},              // 5
    {6, "o0d6d6j0j s5n1m0i0g"},                // 6
    {6, "l0n6n2d"},                            // 7
    {6, "o1n5n5i1i o0i6i6d0d"},                // 8
    {6, "o0n6n6h0h s1d5e6i6k"},                // 9
    {0, "l0d0d l0j0j"},                        // :
    {1, "l1d0b l1j1j"},                        // ;
    {5, "l5k0h5e"},                            // <
    {5, "l0g5g l0i5i"},                        // =
    {5, "l0k5h0e"},                            // >
    {5, "s0l0n5n5i2h2g l2d2d"},                // ?
    {8, "o0d8d8n0n o3g6g6j3j"},                // @
    {6, "l0d3n6d l1g5g"},                      // A
    {6, "l0d0n s0n3n5n5i3i0i s0i3i6i6d3d0d"},  // B
    {6, "s6l6n0n0d6d6f"},                      // C
    {6, "l0d0n s0n2n6n6d2d0d"},                // D
    {6, "l6n0n0d6d l0i5i"},                    // E
    {6, "l6n0n0d l0i5i"},                      // F
    {6, "s6l6n0n0d6d6h l3i6i6h"},              // G
    {6, "l0d0n l6d6n l0i6i"},                  // H
    {0, "l0d0n"},                              // I
    {4, "s4n4g4d0d0g"},                        // J
    {6, "l0d0n l6n0g l2i6d"},                  // K
    {5, "l0n0d5d"},                            // L
    {8, "l0d0n4f8n8d"},                        // M
    {6, "l0d0n6d6n"},                          // N
    {7, "o0n7n7d0d"},                          // O
    {6, "l0d0n s0n3n6n6h3h0h"},                // P
    {7, "o0n7n7d0d l4g7d"},                    // Q
    {6, "l0d0n s0n3n6n6h3h0h l3h6d"},          // R
    {6, "s6l6n0n0i6i6d0d0f"},                  // S
    {6, "l0n6n l3n3d"},                        // T
    {6, "s0n0g0d6d6g6n"},                      // U
    {6, "l0n3d6n"},                            // V
    {8, "l0n2d4l6d8n"},                        // W
    {6, "l0n6d l0d6n"},                        // X
    {6, "l0n3i6n l3i3d"},                      // Y
    {6, "l0n6n0d6d"},                          // Z
    {2, "l2o0o0b2b"},                          // [
    {4, "l0n4c"},                              // backslash
    {2, "l0o2o2b0b"},                          // ]
    {4, "l0k2n4k"},                            // ^
    {6, "l0c6c"},                              // _
    {1, "l0n1l"},                              // `
    {5, "o0d5d5k0k l5k5d"},                    // a
    {5, "l0n0d o0d5d5k0k"},                    // b
    {5, "s5i5k0k0d5d5f"},                      // c
    {5, "o0d5d5k0k l5n5d"},                    // d
    {5, "l0h5h s5h5k0k0d5d5f"},                // e
    {4, "s4n2n2k2d l0k4k"},                    // f
    {5, "o0d5d5k0k s5k5d5a0a0c"},              // g
    {5, "l0n0d s0h0k5k5h5d"},                  // h
    {0, "l0k0d l0n0n"},                        // i
    {2, "s2k2d2a0a l2n2n"},                    // j
    {5, "l0n0d l4k0f l2h5d"},                  // k
    {0, "l0n0d"},                              // l
    {8, "l0k0d s0h0k4k4h4d s4h4k8k8h8d"},      // m
    {5, "l0k0d s0h0k5k5h5d"},                  // n
    {5, "o0d5d5k0k"},                          // o
    {5, "l0k0a o0d5d5k0k"},                    // p
    {5, "l5k5a o0d5d5k0k"},                    // q
    {4, "l0k0d s0g0k4k"},                      // r
    {4, "s4i4k0k0h4g4d0d0f"},                  // s
    {4, "s2n2g2d4d l0k4k"},                    // t
    {5, "s0k0g0d5d5g l5k5d"},                  // u
    {4, "l0k2d4k"},                            // v
    {8, "l0k2d4j6d8k"},                        // w
    {4, "l0k4d l0d4k"},                        // x
    {4, "l0k2d l4k1a"},                        // y
    {4, "l0k4k0d4d"},                          // z
    {3, "s3o1o1j0h s0h1f1b3b"},                // {
    {0, "l0a0o"},                              // |
    {3, "s0o2o2j3h s3h2f2b0b"},                // }
    {5, "s0g1j4f5i"},                          // ~
}};
constexpr Glyph unknown{5, "l0d0n5n5d0d"};

constexpr double gap = 2.6, space = 3.0;           // between glyphs; more for a space
constexpr double raised_size = 0.68, raise = 4.8;  // of exponents
constexpr int pieces = 6;                          // lines of a curve

struct Letter {
    const Glyph* glyph;
    double x, y, scale;  // on the grid
};

const Glyph& glyph_of(char c) {
    const auto index = static_cast<unsigned char>(c) - 32u;
    return index < glyphs.size() ? glyphs[index] : unknown;
}

// Places the letters of a line; returns its width on the grid.
double set_line(std::string_view text, std::vector<Letter>* letters) {
    double x = 0, end = 0;
    bool raised = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '^' && i + 1 < text.size()) {
            raised = true;
            continue;
        }
        const bool kept = text[i] == '\\' && i + 1 < text.size();
        if (kept) ++i;
        const char c = text[i];
        raised = raised && !kept && std::string_view("0123456789+-./").find(c) != std::string_view::npos;
        const Glyph& glyph = glyph_of(c);
        const double scale = raised ? raised_size : 1;
        if (letters) letters->push_back({&glyph, x, raised ? raise : 0, scale});
        end = x + scale * glyph.width;
        x = end + scale * (c == ' ' ? space : gap);
    }
    return end;
}

using Point = std::array<double, 2>;

// The points along a stroke of a glyph.
void trace(std::string_view word, std::vector<Point>& line) {
    std::vector<Point> control;
    for (std::size_t i = 1; i + 1 < word.size(); i += 2) {
        control.push_back({static_cast<double>(word[i] - '0'), static_cast<double>(word[i + 1] - 'd')});
    }
    line.clear();
    if (word[0] == 'l') {
        line = control;
        return;
    }
    const auto middle = [](const Point& a, const Point& b) { return Point{(a[0] + b[0]) / 2, (a[1] + b[1]) / 2}; };
    const bool closed = word[0] == 'o';
    const std::size_t n = control.size(), begin = closed ? 0 : 1, end = closed ? n : n - 1;
    for (std::size_t i = begin; i < end; ++i) {
        const Point &before = control[(i + n - 1) % n], &at = control[i], &after = control[(i + 1) % n];
        const Point from = !closed && i == 1 ? before : middle(before, at);
        const Point to = !closed && i == n - 2 ? after : middle(at, after);
        for (int k = line.empty() ? 0 : 1; k <= pieces; ++k) {
            const double t = static_cast<double>(k) / pieces, s = 1 - t;
            line.push_back({s * s * from[0] + 2 * s * t * at[0] + t * t * to[0],
                            s * s * from[1] + 2 * s * t * at[1] + t * t * to[1]});
        }
    }
}

}  // namespace

double text_width(std::string_view text, const TextStyle& style) {
    return set_line(text, nullptr) * style.size / 10;
}

void draw_text(std::string_view text, double x, double y, double align, const TextStyle& style,
               std::vector<Stroke>& strokes) {
    std::vector<Letter> letters;
    const double width = set_line(text, &letters), unit = style.size / 10;
    std::vector<Point> line;
    for (const Letter& letter : letters) {
        const auto place = [&](const Point& p) {
            const double along = (letter.x + letter.scale * p[0] - align * width) * unit;
            const double above = (letter.y + letter.scale * p[1] - 5) * unit;
            return style.upwards ? Point{x - above, y - along} : Point{x + along, y - above};
        };
        std::string_view rest = letter.glyph->strokes;
        while (!rest.empty()) {
            const std::string_view word = rest.substr(0, rest.find(' '));
            rest.remove_prefix(std::min(rest.size(), word.size() + 1));
            trace(word, line);
            for (std::size_t i = 0; i + 1 < line.size(); ++i) {
                const Point a = place(line[i]), b = place(line[i + 1]);
                strokes.push_back(stroke({a[0], a[1], 0}, {b[0], b[1], 0}, style.weight * style.size, style.color));
            }
        }
    }
}

}  // namespace votess::picture
