#include "core/system.hpp"

#ifdef _WIN32
#ifndef NOMINMAX
#define NOMINMAX
#endif
#define WIN32_LEAN_AND_MEAN
#include <windows.h>
// These follow it.
#include <fcntl.h>
#include <io.h>
#include <process.h>
#include <psapi.h>
#include <shellapi.h>
#include <sys/stat.h>
#else
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#endif
#ifdef __linux__
#include <sched.h>
#endif
#ifdef __APPLE__
#include <mach-o/dyld.h>
#include <mach/mach.h>
#endif
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <new>
#include <thread>

#include "core/disk_space.hpp"
#include "core/processors.hpp"

namespace votess::system {
namespace {

namespace fs = std::filesystem;

volatile std::sig_atomic_t signal_that_came = 0;  // a handler can only reach a global

void remember(int signal) {
    signal_that_came = signal;
}

// Some systems do no more at once.
std::size_t piece(std::size_t bytes) {
    return std::min(bytes, std::size_t{1} << 30);
}

}  // namespace

fs::path path_of(std::string_view text) {
    return {std::u8string(text.begin(), text.end())};
}

std::string text_of(const fs::path& path) {
    const std::u8string text = path.u8string();
    return {text.begin(), text.end()};
}

File File::standard_input() {
    return File(0);
}

File File::standard_output() {
    return File(1);
}

bool File::rewind() {
#ifdef _WIN32
    return ::_lseeki64(descriptor_, 0, SEEK_SET) == 0;
#else
    return ::lseek(descriptor_, 0, SEEK_SET) == 0;
#endif
}

int received_signal() noexcept {
    return signal_that_came;
}

#ifdef _WIN32

namespace {

int open(const fs::path& path, int flags) {
    return ::_wopen(path.c_str(), flags | _O_BINARY | _O_NOINHERIT, _S_IREAD | _S_IWRITE);
}

// Returns what a call did at a position, -1 for an error.
template <class Bytes, class Call>
std::ptrdiff_t at_position(int descriptor, std::uint64_t position, std::span<Bytes> bytes, const Call& call) {
    OVERLAPPED at{};
    at.Offset = static_cast<DWORD>(position);
    at.OffsetHigh = static_cast<DWORD>(position >> 32);
    DWORD done = 0;
    const auto handle = reinterpret_cast<HANDLE>(::_get_osfhandle(descriptor));
    if (call(handle, bytes.data(), static_cast<DWORD>(piece(bytes.size())), &done, &at)) return done;
    if (::GetLastError() == ERROR_HANDLE_EOF) return 0;
    errno = ::GetLastError() == ERROR_DISK_FULL ? ENOSPC : EIO;
    return -1;
}

std::string utf8(const wchar_t* text) {
    return text_of(fs::path(text));
}

}  // namespace

File File::open_to_read(const fs::path& path) {
    return File(open(path, _O_RDONLY | _O_SEQUENTIAL));
}

File File::open_to_write(const fs::path& path) {
    return File(open(path, _O_WRONLY));
}

File File::create(const fs::path& path) {
    return File(open(path, _O_WRONLY | _O_CREAT | _O_EXCL));
}

File File::temporary(const fs::path& folder) {
    for (int attempt = 0; attempt < 1000; ++attempt) {
        const fs::path name =
            folder / (".votess-" + std::to_string(process_id()) + "-" + std::to_string(std::rand()) + ".tmp");
        const int descriptor = open(name, _O_RDWR | _O_CREAT | _O_EXCL | _O_TEMPORARY);
        if (descriptor >= 0 || errno != EEXIST) return File(descriptor);
    }
    return {};
}

File File::nameless(const fs::path&) {
    return {};
}

std::optional<std::uint64_t> File::regular_size() const {
    struct _stat64 facts {};
    if (::_fstat64(descriptor_, &facts) != 0 || (facts.st_mode & _S_IFMT) != _S_IFREG) return {};
    return static_cast<std::uint64_t>(facts.st_size);
}

bool File::is_device() const {
    struct _stat64 facts {};
    return ::_fstat64(descriptor_, &facts) == 0 && (facts.st_mode & _S_IFMT) == _S_IFCHR;
}

std::ptrdiff_t File::read(std::span<std::byte> to) {
    return ::_read(descriptor_, to.data(), static_cast<unsigned>(piece(to.size())));
}

std::ptrdiff_t File::write(std::span<const std::byte> bytes) {
    const int done = ::_write(descriptor_, bytes.data(), static_cast<unsigned>(piece(bytes.size())));
    // A closed pipe has this error too.
    if (done < 0 && errno == EINVAL && !regular_size()) errno = EPIPE;
    return done;
}

std::ptrdiff_t File::read_at(std::uint64_t position, std::span<std::byte> to) const {
    return at_position(descriptor_, position, to, ::ReadFile);
}

std::ptrdiff_t File::write_at(std::uint64_t position, std::span<const std::byte> bytes) {
    return at_position(descriptor_, position, bytes, ::WriteFile);
}

bool File::skip(std::uint64_t count) {
    return ::_lseeki64(descriptor_, static_cast<std::int64_t>(count), SEEK_CUR) >= 0;
}

int File::sync() const {
    return ::_commit(descriptor_) == 0 ? 0 : errno;
}

bool File::close() noexcept {
    const int descriptor = std::exchange(descriptor_, -1);
    return descriptor <= 2 || ::_close(descriptor) == 0;
}

fs::path File::path() const {
    return {};
}

bool File::give_name(const fs::path&) const {
    return false;
}

int sync_folder(const fs::path&) {
    return 0;
}

bool may_write(const fs::path& path) {
    return ::_waccess(path.c_str(), 2) == 0;
}

fs::path temporary_folder() {
    std::array<wchar_t, MAX_PATH + 1> folder{};
    ::GetTempPathW(static_cast<DWORD>(folder.size()), folder.data());
    return folder.data();
}

SharedLibrary SharedLibrary::open(const fs::path& path, std::string& failure) {
    const DWORD flags = path.is_absolute() ? LOAD_WITH_ALTERED_SEARCH_PATH : LOAD_LIBRARY_SEARCH_DEFAULT_DIRS;
    const HMODULE handle = ::LoadLibraryExW(path.c_str(), nullptr, flags);
    if (handle == nullptr) {
        failure = text_of(path) + ": " + std::system_category().message(static_cast<int>(::GetLastError()));
        return {};
    }
    HMODULE pinned = nullptr;
    ::GetModuleHandleExW(GET_MODULE_HANDLE_EX_FLAG_PIN, path.c_str(), &pinned);
    return SharedLibrary(reinterpret_cast<void*>(handle));
}

SharedLibrary::~SharedLibrary() {
    if (handle_ != nullptr) ::FreeLibrary(static_cast<HMODULE>(handle_));
}

void* SharedLibrary::symbol(const char* name) const {
    return reinterpret_cast<void*>(::GetProcAddress(static_cast<HMODULE>(handle_), name));
}

std::vector<std::string> vulkan_loaders() {
    return {"vulkan-1.dll"};
}

struct SignalGuard::Old {
    static constexpr std::array signals{SIGINT, SIGTERM, SIGBREAK};
    std::array<void (*)(int), signals.size()> handlers{};
};

// A handler is called once: then the default action is back.
SignalGuard::SignalGuard() : old_(std::make_unique<Old>()) {
    for (std::size_t i = 0; i < Old::signals.size(); ++i) {
        old_->handlers[i] = std::signal(Old::signals[i], remember);
        if (old_->handlers[i] == SIG_IGN) std::signal(Old::signals[i], SIG_IGN);
    }
}

SignalGuard::~SignalGuard() {
    for (std::size_t i = 0; i < Old::signals.size(); ++i)
        if (old_->handlers[i] != SIG_ERR) std::signal(Old::signals[i], old_->handlers[i]);
}

std::vector<std::string> begin_program(int argc, const char* const* argv) {
    for (int descriptor = 0; descriptor <= 2; ++descriptor) ::_setmode(descriptor, _O_BINARY);
    int count = 0;
    wchar_t** const wide = ::CommandLineToArgvW(::GetCommandLineW(), &count);
    if (wide == nullptr) return {argv, argv + argc};
    std::vector<std::string> arguments;
    for (int i = 0; i < count; ++i) arguments.push_back(utf8(wide[i]));
    ::LocalFree(wide);
    return arguments;
}

// Returns false for a console that cannot erase a line.
bool stderr_is_terminal() {
    DWORD mode = 0;
    const HANDLE console = ::GetStdHandle(STD_ERROR_HANDLE);
    return ::GetConsoleMode(console, &mode) != 0 &&
           ::SetConsoleMode(console, mode | ENABLE_VIRTUAL_TERMINAL_PROCESSING) != 0;
}

fs::path program_path() {
    std::wstring path(MAX_PATH, L'\0');
    for (;;) {
        const DWORD size = ::GetModuleFileNameW(nullptr, path.data(), static_cast<DWORD>(path.size()));
        if (size < path.size()) return path.substr(0, size);
        path.resize(2 * path.size());
    }
}

std::int64_t process_id() {
    return ::_getpid();
}

// The mask is that of one group of at most 64 processors, and full unless something limits the process.
unsigned processors() {
    DWORD_PTR own = 0, all = 0;
    const bool limited = ::GetProcessAffinityMask(::GetCurrentProcess(), &own, &all) != 0 && own != 0 && own != all;
    return limited ? static_cast<unsigned>(std::popcount(own)) : std::max(1u, std::thread::hardware_concurrency());
}

namespace {

PROCESS_MEMORY_COUNTERS memory_counters() {
    PROCESS_MEMORY_COUNTERS counters{};
    ::K32GetProcessMemoryInfo(::GetCurrentProcess(), &counters, sizeof counters);
    return counters;
}

}  // namespace

std::uint64_t peak_memory() {
    return memory_counters().PeakWorkingSetSize;
}

std::uint64_t resident_memory() {
    return memory_counters().WorkingSetSize;
}

void give_back_memory() {}
void touch_pages(void*, std::size_t) {}
void release_pages(void*, std::size_t) {}
void prefer_huge_pages(void*, std::size_t) {}
bool move_pages(void*, void*, std::size_t) {
    return false;
}

#else

namespace {

#ifdef __linux__
// Opens a file without a name; -1 where the file system has none.
int open_nameless(const fs::path& folder, int flags, unsigned mode) {
#ifdef O_TMPFILE
    return ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC | flags, mode);
#else
    return -1;
#endif
}
#else
int open_nameless(const fs::path&, int, unsigned) {
    return -1;
}
#endif

int sync(int descriptor) {
    while (::fsync(descriptor) != 0) {
        if (errno == EINTR) continue;
        const bool unknown = errno == EINVAL || errno == EROFS || errno == ENOTSUP || errno == ENOSYS;
        return unknown ? 0 : errno;
    }
    return 0;
}

}  // namespace

File File::open_to_read(const fs::path& path) {
    return File(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
}

File File::open_to_write(const fs::path& path) {
    return File(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
}

File File::create(const fs::path& path) {
    return File(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
}

File File::temporary(const fs::path& folder) {
    int descriptor = open_nameless(folder, O_EXCL, 0600);
    if (descriptor < 0) {
        std::string name = (folder / ".votess-XXXXXX").native();
        descriptor = ::mkstemp(name.data());
        if (descriptor >= 0) {
            ::unlink(name.c_str());
            ::fcntl(descriptor, F_SETFD, FD_CLOEXEC);
        }
    }
    return File(descriptor);
}

// Without /proc the file could not get a name.
File File::nameless(const fs::path& folder) {
    File file(open_nameless(folder, 0, 0666));
    if (file.is_open() && ::access(file.path().c_str(), F_OK) == 0) return file;
    return {};
}

std::optional<std::uint64_t> File::regular_size() const {
    struct stat facts {};
    if (::fstat(descriptor_, &facts) != 0 || !S_ISREG(facts.st_mode)) return {};
    return static_cast<std::uint64_t>(facts.st_size);
}

bool File::is_device() const {
    struct stat facts {};
    return ::fstat(descriptor_, &facts) == 0 && S_ISCHR(facts.st_mode);
}

std::ptrdiff_t File::read(std::span<std::byte> to) {
    return ::read(descriptor_, to.data(), piece(to.size()));
}

std::ptrdiff_t File::write(std::span<const std::byte> bytes) {
    return ::write(descriptor_, bytes.data(), piece(bytes.size()));
}

std::ptrdiff_t File::read_at(std::uint64_t position, std::span<std::byte> to) const {
    return ::pread(descriptor_, to.data(), piece(to.size()), static_cast<off_t>(position));
}

std::ptrdiff_t File::write_at(std::uint64_t position, std::span<const std::byte> bytes) {
    return ::pwrite(descriptor_, bytes.data(), piece(bytes.size()), static_cast<off_t>(position));
}

bool File::skip(std::uint64_t count) {
    return ::lseek(descriptor_, static_cast<off_t>(count), SEEK_CUR) >= 0;
}

int File::sync() const {
    return system::sync(descriptor_);
}

bool File::close() noexcept {
    const int descriptor = std::exchange(descriptor_, -1);
    return descriptor <= 2 || ::close(descriptor) == 0;
}

fs::path File::path() const {
    return "/proc/self/fd/" + std::to_string(descriptor_);
}

bool File::give_name(const fs::path& name) const {
    return ::linkat(AT_FDCWD, path().c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0;
}

int sync_folder(const fs::path& folder) {
    const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) return errno == EACCES ? 0 : errno;
    const int error = sync(descriptor);
    ::close(descriptor);
    return error;
}

bool may_write(const fs::path& path) {
    std::error_code problem;
    return ::access(path.c_str(), fs::is_directory(path, problem) ? W_OK | X_OK : W_OK) == 0;
}

fs::path temporary_folder() {
    const char* const named = std::getenv("TMPDIR");
    return named != nullptr && *named != '\0' ? named : "/tmp";
}

SharedLibrary SharedLibrary::open(const fs::path& path, std::string& failure) {
    void* const handle = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (handle == nullptr) failure = ::dlerror();
    return SharedLibrary(handle);
}

SharedLibrary::~SharedLibrary() {
    if (handle_ != nullptr) ::dlclose(handle_);
}

void* SharedLibrary::symbol(const char* name) const {
    return ::dlsym(handle_, name);
}

std::vector<std::string> vulkan_loaders() {
#ifdef __APPLE__
    // A signed program searches neither folder of Vulkan's SDK and of Homebrew.
    return {"libvulkan.1.dylib", "libvulkan.dylib", "libMoltenVK.dylib", "/usr/local/lib/libvulkan.1.dylib",
            "/opt/homebrew/lib/libvulkan.1.dylib"};
#else
    return {"libvulkan.so.1"};
#endif
}

struct SignalGuard::Old {
    static constexpr std::array signals{SIGINT, SIGTERM, SIGHUP};
    std::array<struct sigaction, signals.size()> actions{};
};

SignalGuard::SignalGuard() : old_(std::make_unique<Old>()) {
    for (std::size_t i = 0; i < Old::signals.size(); ++i) {
        struct sigaction action {};
        action.sa_handler = remember;
        // The first signal restores the default action, so a second Ctrl-C always ends the program.
        action.sa_flags = static_cast<int>(SA_RESETHAND);
        sigemptyset(&action.sa_mask);
        sigaction(Old::signals[i], &action, &old_->actions[i]);
        // Keeps a signal ignored that was ignored at the start (nohup, a background job).
        if (old_->actions[i].sa_handler == SIG_IGN) sigaction(Old::signals[i], &old_->actions[i], nullptr);
    }
}

SignalGuard::~SignalGuard() {
    for (std::size_t i = 0; i < Old::signals.size(); ++i) sigaction(Old::signals[i], &old_->actions[i], nullptr);
}

// An empty file is read-only, so that writing to a closed stream still fails.
std::vector<std::string> begin_program(int argc, const char* const* argv) {
    for (int descriptor = 0; descriptor <= 2; ++descriptor)
        if (::fcntl(descriptor, F_GETFD) < 0 && ::open("/dev/null", O_RDONLY) < 0) break;
    std::signal(SIGPIPE, SIG_IGN);  // a closed pipe becomes a write error, so that temporary files are removed
    static_assert(closed_pipe == SIGPIPE);
    return {argv, argv + argc};
}

bool stderr_is_terminal() {
    return ::isatty(STDERR_FILENO) == 1;
}

std::int64_t process_id() {
    return ::getpid();
}

#ifdef __APPLE__

fs::path program_path() {
    std::string path(1024, '\0');
    auto size = static_cast<std::uint32_t>(path.size());
    while (::_NSGetExecutablePath(path.data(), &size) != 0) path.resize(size);
    return fs::canonical(path.c_str());
}

std::uint64_t peak_memory() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss);
}

std::uint64_t resident_memory() {
    mach_task_basic_info info{};
    mach_msg_type_number_t count = MACH_TASK_BASIC_INFO_COUNT;
    const auto result =
        ::task_info(mach_task_self(), MACH_TASK_BASIC_INFO, reinterpret_cast<task_info_t>(&info), &count);
    return result == KERN_SUCCESS ? info.resident_size : 0;
}

#else

fs::path program_path() {
    return fs::read_symlink("/proc/self/exe");
}

std::uint64_t peak_memory() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

std::uint64_t resident_memory() {
    std::ifstream statm("/proc/self/statm");
    std::uint64_t size = 0, resident = 0;
    statm >> size >> resident;
    return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

#endif

void give_back_memory() {
#ifdef __GLIBC__
    (void)malloc_trim(0);
#endif
}

#ifdef __linux__

// The system refuses a set that is smaller than its own.
unsigned processors() {
    for (std::size_t bits = 1024; bits <= std::size_t{1} << 20; bits *= 2) {
        std::vector<std::uint64_t> set(bits / 64);
        if (::sched_getaffinity(0, bits / 8, reinterpret_cast<cpu_set_t*>(set.data())) != 0) continue;
        unsigned count = 0;
        for (const std::uint64_t word : set) count += static_cast<unsigned>(std::popcount(word));
        return std::max(1u, count);
    }
    return std::max(1u, std::thread::hardware_concurrency());
}

void touch_pages([[maybe_unused]] void* begin, [[maybe_unused]] std::size_t bytes) {
#ifdef MADV_POPULATE_WRITE
    ::madvise(begin, bytes, MADV_POPULATE_WRITE);
#endif
}

void release_pages(void* begin, std::size_t bytes) {
    ::madvise(begin, bytes, MADV_DONTNEED);
}

void prefer_huge_pages(void* begin, std::size_t bytes) {
    ::madvise(begin, bytes, MADV_HUGEPAGE);
}

// Kernels before 5.7, and some sandboxes, refuse the flag. After any other failure `to` may have lost its mapping.
bool move_pages([[maybe_unused]] void* from, [[maybe_unused]] void* to, [[maybe_unused]] std::size_t bytes) {
#ifdef MREMAP_DONTUNMAP
    if (::mremap(from, bytes, bytes, MREMAP_MAYMOVE | MREMAP_FIXED | MREMAP_DONTUNMAP, to) == to) return true;
    const bool is_mapped = ::madvise(to, bytes, MADV_NORMAL) == 0;
    if (!is_mapped && ::mmap(to, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED, -1, 0) != to)
        throw std::bad_alloc();
#endif
    return false;
}

#else

unsigned processors() {
    return std::max(1u, std::thread::hardware_concurrency());
}

void touch_pages(void*, std::size_t) {}
void release_pages(void*, std::size_t) {}
void prefer_huge_pages(void*, std::size_t) {}
bool move_pages(void*, void*, std::size_t) {
    return false;
}

#endif
#endif

bool release_disk_space([[maybe_unused]] const File& file, [[maybe_unused]] std::uint64_t position,
                        [[maybe_unused]] std::uint64_t bytes) {
#ifdef FALLOC_FL_PUNCH_HOLE
    const int descriptor = ::open(file.path().c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor < 0) return false;
    const bool done = ::fallocate(descriptor, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, static_cast<off_t>(position),
                                  static_cast<off_t>(bytes)) == 0;
    ::close(descriptor);
    return done;
#else
    return false;
#endif
}

}  // namespace votess::system
