#include "files/hdf5_nodes.hpp"

#include <array>
#include <utility>

#include "core/errors.hpp"

namespace votess::files {
namespace {

constexpr std::uint64_t undefined = ~std::uint64_t{0};
constexpr std::uint64_t superblock_bytes = 96;
constexpr std::size_t name_bytes = 33;
constexpr std::size_t max_children = 65'000;  // an object counts its messages in 16 bits

std::uint64_t padded(std::uint64_t bytes) {
    return (bytes + 7) / 8 * 8;
}

void put(std::string& out, std::uint64_t value, int bytes) {
    for (int k = 0; k < bytes; ++k) out += static_cast<char>(value >> 8 * k);
}

std::uint64_t number_bytes(NodeType type) {
    switch (type) {
        case NodeType::none:
            return 0;
        case NodeType::text:
            return 1;
        case NodeType::int32:
        case NodeType::float32:
            return 4;
        default:
            return 8;
    }
}

const char* name_of(NodeType type) {
    constexpr std::array names{"MT", "C1", "I4", "I8", "R4", "R8"};
    return names[static_cast<std::size_t>(type)];
}

// Returns the message that describes a number. Characters are signed bytes.
std::string number_type(NodeType type) {
    const std::uint64_t bytes = number_bytes(type);
    const bool is_float = type == NodeType::float32 || type == NodeType::float64, is_double = bytes == 8;
    std::string out;
    put(out, is_float ? 0x11 : 0x10, 1);
    put(out, is_float ? 0x20 | (8 * bytes - 1) << 8 : 0x08, 3);  // little endian; place of the sign, or signed
    put(out, bytes, 4);
    put(out, 0, 2);
    put(out, 8 * bytes, 2);
    if (!is_float) return out;
    put(out, is_double ? 52 : 23, 1);  // place and size of the exponent, then of the mantissa
    put(out, is_double ? 11 : 8, 1);
    put(out, 0, 1);
    put(out, is_double ? 52 : 23, 1);
    put(out, is_double ? 1023 : 127, 4);
    return out;
}

std::string text_type(std::uint64_t bytes) {
    std::string out;
    put(out, 0x13, 4);  // ends with a zero
    put(out, bytes, 4);
    return out;
}

std::string space(const std::vector<std::uint64_t>& extent) {
    std::string out;
    put(out, 1, 1);
    put(out, extent.size(), 7);
    for (const std::uint64_t count : extent) put(out, count, 8);
    return out;
}

// The header of an object: messages.
class Header {
public:
    void add(int type, std::string message) {
        message.resize(padded(message.size()));
        put(messages_, static_cast<std::uint64_t>(type), 2);
        put(messages_, message.size(), 2);
        put(messages_, 0, 4);
        messages_ += message;
        ++count_;
    }
    void add_attribute(const std::string& name, const std::string& type, const std::string& extent,
                       const std::string& value) {
        std::string message;
        put(message, 3, 2);
        for (const std::size_t bytes : {name.size() + 1, type.size(), extent.size()}) put(message, bytes, 2);
        put(message, 0, 1);
        message += name + '\0' + type + extent + value;
        add(0x0C, message);
    }
    void add_text(const std::string& name, std::string value, std::size_t bytes) {
        value.resize(bytes);
        add_attribute(name, text_type(bytes), space({}), value);
    }
    [[nodiscard]] std::string bytes() const {
        std::string out;
        put(out, 1, 2);
        put(out, count_, 2);
        put(out, 1, 4);
        put(out, messages_.size(), 8);
        return out + messages_;
    }

private:
    std::string messages_;
    std::size_t count_ = 0;
};

struct Link {
    std::string name;
    std::uint64_t place;
};

// links: in the order of creation, which CGNS keeps.
void add_links(Header& header, const std::vector<Link>& links) {
    std::string info;
    put(info, 0x300, 2);
    put(info, links.size(), 8);
    for (int k = 0; k < 3; ++k) put(info, undefined, 8);
    header.add(0x02, info);
    header.add(0x0A, std::string(2, '\0'));
    for (std::size_t k = 0; k < links.size(); ++k) {
        std::string link;
        put(link, 0x401, 2);
        put(link, k, 8);
        put(link, links[k].name.size(), 1);
        link += links[k].name;
        put(link, links[k].place, 8);
        header.add(0x06, link);
    }
}

std::string set_header(NodeType type, const std::vector<std::uint64_t>& extent, std::uint64_t place,
                       std::uint64_t bytes) {
    Header header;
    header.add(0x01, space(extent));
    header.add(0x03, number_type(type));
    header.add(0x05, std::string("\2\1\1\0", 4));  // no fill value
    std::string layout;
    put(layout, 0x103, 2);
    put(layout, place, 8);
    put(layout, bytes, 8);
    header.add(0x08, layout);
    return header.bytes();
}

std::uint64_t array_bytes(const Hdf5Node& node) {
    std::uint64_t bytes = node.put ? number_bytes(node.type) : 0;
    for (const std::uint64_t count : node.extent) bytes *= count;
    return bytes;
}

// The superblock comes first, then arrays, then headers: those of children before their parents'.
class NodeWriter {
public:
    explicit NodeWriter(const Hdf5Node& root) {
        each_array(root, [&](const Hdf5Node& node) { headers_begin_ += padded(array_bytes(node)); });
        root_ = add_group(root);
    }

    void write(const Hdf5Node& root, ByteSink& out) const {
        const std::uint64_t end = headers_begin_ + headers_.size();
        out.set_total(end);
        std::string first("\x89HDF\r\n\x1a\n");
        put(first, 0, 5);
        put(first, 8, 1);  // bytes of places and lengths
        put(first, 8, 2);
        put(first, 4, 2);  // widths of trees that are not used
        put(first, 16, 6);
        for (const std::uint64_t place : {std::uint64_t{0}, undefined, end, undefined, std::uint64_t{0}, root_})
            put(first, place, 8);
        first.resize(superblock_bytes);
        out.put(first);
        each_array(root, [&](const Hdf5Node& node) {
            const std::uint64_t bytes = array_bytes(node);
            node.put(out);
            out.put(std::string(padded(bytes) - bytes, '\0'));
        });
        out.put(headers_);
    }

private:
    static void each_array(const Hdf5Node& node, const auto& use) {
        if (node.put) use(node);
        for (const Hdf5Node& child : node.children) each_array(child, use);
    }

    std::uint64_t append(const std::string& header) {
        headers_ += header;
        return headers_begin_ + headers_.size() - header.size();
    }
    std::uint64_t add_set(const Hdf5Node& node) {
        const std::uint64_t bytes = array_bytes(node), place = next_array_;
        next_array_ += padded(bytes);
        return append(set_header(node.type, node.extent, place, bytes));
    }
    // Returns the place of the node's group.
    std::uint64_t add_group(const Hdf5Node& node) {
        if (node.children.size() > max_children)
            refuse("a group of HDF5 would have " + std::to_string(node.children.size()) + " members: it has " +
                   std::to_string(max_children) + " at most");
        std::vector<Link> links;
        if (node.put) links.push_back({" data", add_set(node)});
        for (const Hdf5Node& child : node.children)
            links.push_back({child.name, child.label.empty() ? add_set(child) : add_group(child)});
        Header header;
        add_links(header, links);
        header.add_text("name", node.name, name_bytes);
        header.add_text("label", node.label, name_bytes);
        header.add_text("type", name_of(node.type), 3);
        header.add_attribute("flags", number_type(NodeType::int32), space({1}), std::string(4, '\0'));
        return append(header.bytes());
    }

    std::uint64_t headers_begin_ = superblock_bytes, next_array_ = superblock_bytes, root_ = 0;
    std::string headers_;
};

Hdf5Node text(const std::string& name, std::string value, std::size_t bytes) {
    value.resize(bytes);
    return {name, {}, NodeType::text, {bytes}, [value](ByteSink& out) { out.put(value); }};
}

}  // namespace

void write_nodes(std::vector<Hdf5Node> nodes, ByteSink& out) {
    Hdf5Node root{"HDF5 MotherNode", "Root Node of HDF5 File", NodeType::none, {}, {}, std::move(nodes)};
    root.children.insert(root.children.begin(), {text(" format", "IEEE_LITTLE_32", 15),
                                                 text(" hdf5version", "HDF5 Version 1.8.0", name_bytes)});
    NodeWriter(root).write(root, out);
}

}  // namespace votess::files
