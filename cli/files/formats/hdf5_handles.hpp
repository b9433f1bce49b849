// Owners of HDF5 identifiers, which close them at the end of their scope.
#pragma once

#include <hdf5.h>

#include <cstring>
#include <string>
#include <utility>

namespace clvotess {

class Hdf5Handle {
public:
    using Close = herr_t (*)(hid_t);

    Hdf5Handle() = default;
    Hdf5Handle(hid_t id, Close close) : id_(id), close_(close) {}
    Hdf5Handle(Hdf5Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
    Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
        std::swap(id_, other.id_);
        std::swap(close_, other.close_);
        return *this;
    }
    ~Hdf5Handle() { (void)close(); }

    [[nodiscard]] bool valid() const noexcept { return id_ >= 0; }
    [[nodiscard]] hid_t id() const noexcept { return id_; }
    // Closes the object and returns whether that succeeded. Data may reach the file only now.
    [[nodiscard]] bool close() noexcept {
        const hid_t id = std::exchange(id_, H5I_INVALID_HID);
        return id < 0 || close_(id) >= 0;
    }

private:
    hid_t id_ = H5I_INVALID_HID;
    Close close_ = nullptr;
};

// Turns off HDF5's messages on stderr, which each thread has for itself, and its work at exit, where it would continue
// to write a failed file. Call it on entry to the module.
inline void begin_hdf5() {
    H5dont_atexit();
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

// Returns what to do if the last call failed at a part whose version this HDF5 does not know; "" after other failures.
inline std::string newer_version() {
    bool found = false;
    const auto visit = [](unsigned, const H5E_error2_t* error, void* to) -> herr_t {
        if (error->desc && std::strstr(error->desc, "version number")) *static_cast<bool*>(to) = true;
        return 0;
    };
    if (H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, visit, &found) < 0 || !found) return {};
    unsigned major = 0, minor = 0, release = 0;
    H5get_libversion(&major, &minor, &release);
    return ": a newer HDF5 than " + std::to_string(major) + "." + std::to_string(minor) + "." +
           std::to_string(release) + " wrote it, or it is damaged; write it without libver=\"latest\"";
}

}  // namespace clvotess
