// CUDA's driver without a GPU, for tests of pyvotess on lavapipe. Exported memory is mapped. A stream is a queue: its
// work runs when the host waits for the stream. Semaphores, which lavapipe cannot export, are two functions of the
// test.
#define _GNU_SOURCE
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

enum { OUT_OF_MEMORY = 2, INVALID = 1 };
struct handle {
    int type;
    union {
        int fd;
        void* pair[2];
    } handle;
    uint64_t size;
    uint32_t flags, reserved[16];
};
struct part {
    uint64_t offset, size;
    uint32_t flags, reserved[16];
};
struct value {
    uint64_t value;
    uint32_t others[16], flags, reserved[16];
};

static struct {
    unsigned char uuid[16];
    int version, devices, fail_import, capturing, ordinal;
    void (*signal)(uint64_t);
    void (*wait)(uint64_t);
} fake = {{0}, 12040, 1, 0, 0, 0, NULL, NULL};
static struct work {
    int kind;
    uint64_t to, from, size;
} queue[64];
static int queued, live_memory, live_semaphores, contexts, depth;
static struct {
    void* base;
    size_t size;
    void* data;
} memory;

void fake_set(const unsigned char* uuid, void (*signal)(uint64_t), void (*wait)(uint64_t)) {
    memcpy(fake.uuid, uuid, 16);
    fake.signal = signal;
    fake.wait = wait;
}
void fake_option(const char* name, int value) {
    if (!strcmp(name, "version")) fake.version = value;
    if (!strcmp(name, "devices")) fake.devices = value;
    if (!strcmp(name, "fail_import")) fake.fail_import = value;
    if (!strcmp(name, "capturing")) fake.capturing = value;
    if (!strcmp(name, "ordinal")) fake.ordinal = value;
}
int fake_queued(void) {
    return queued;
}
int fake_live(void) {
    return live_memory + live_semaphores + contexts + depth;
}

static int later(int kind, uint64_t to, uint64_t from, uint64_t size) {
    if (queued == 64 || depth == 0) return INVALID;
    queue[queued++] = (struct work){kind, to, from, size};
    return 0;
}

int cuInit(unsigned flags) {
    return (int)flags;
}
int cuDriverGetVersion(int* version) {
    return *version = fake.version, 0;
}
int cuGetErrorName(int status, const char** name) {
    return *name = status == OUT_OF_MEMORY ? "CUDA_ERROR_OUT_OF_MEMORY" : "CUDA_ERROR_INVALID_VALUE", 0;
}
int cuDeviceGetCount(int* count) {
    return *count = fake.devices, 0;
}
int cuDeviceGet(int* device, int ordinal) {
    return *device = ordinal, 0;
}
int cuDeviceGetUuid(void* uuid, int device) {
    return memcpy(uuid, fake.uuid, 16), device * 0;
}
int cuDevicePrimaryCtxRetain(void** context, int device) {
    return ++contexts, *context = &fake, device * 0;
}
int cuDevicePrimaryCtxRelease_v2(int device) {
    return --contexts, device * 0;
}
int cuCtxPushCurrent_v2(void* context) {
    return ++depth, context == &fake ? 0 : INVALID;
}
int cuCtxPopCurrent_v2(void** context) {
    return --depth, *context = &fake, 0;
}
int cuImportExternalMemory(void** out, const struct handle* of) {
    if (fake.fail_import) return OUT_OF_MEMORY;
    if (of->type != 1 || of->flags != 1 || depth == 0) return INVALID;
    struct stat info;
    if (fstat(of->handle.fd, &info) != 0 || (uint64_t)info.st_size < of->size) return INVALID;
    memory.size = (size_t)info.st_size;
    memory.base = mmap(NULL, memory.size, PROT_READ | PROT_WRITE, MAP_SHARED, of->handle.fd, 0);
    if (memory.base == MAP_FAILED) return INVALID;
    // llvmpipe has a header before the data, which begin at the next page.
    memory.data = (char*)memory.base + (memory.size == of->size ? 0 : 4096);
    close(of->handle.fd);  // the importer owns it
    return ++live_memory, *out = &memory, 0;
}
int cuExternalMemoryGetMappedBuffer(uint64_t* address, void* of, const struct part* part) {
    if (of != &memory || part->offset != 0) return INVALID;
    return *address = (uint64_t)(uintptr_t)memory.data, 0;
}
int cuMemFree_v2(uint64_t address) {
    return address == (uint64_t)(uintptr_t)memory.data ? 0 : INVALID;
}
int cuDestroyExternalMemory(void* of) {
    munmap(memory.base, memory.size);
    return --live_memory, of == &memory ? 0 : INVALID;
}
int cuImportExternalSemaphore(void** out, const struct handle* of) {
    return of->type == 9 ? (++live_semaphores, *out = &queue, 0) : INVALID;
}
int cuDestroyExternalSemaphore(void* of) {
    return --live_semaphores, of == &queue ? 0 : INVALID;
}
int cuSignalExternalSemaphoresAsync(void** of, const struct value* values, unsigned count, void* stream) {
    (void)stream;
    return *of == &queue && count == 1 ? later(1, values->value, 0, 0) : INVALID;
}
int cuWaitExternalSemaphoresAsync(void** of, const struct value* values, unsigned count, void* stream) {
    (void)stream;
    return *of == &queue && count == 1 ? later(2, values->value, 0, 0) : INVALID;
}
int cuMemcpyDtoDAsync_v2(uint64_t to, uint64_t from, size_t size, void* stream) {
    (void)stream;
    return later(3, to, from, size);
}
int cuPointerGetAttribute(void* out, int attribute, uint64_t address) {
    if (attribute != 9 || address == 0) return INVALID;
    return *(int*)out = fake.ordinal, 0;
}
int cuStreamIsCapturing(void* stream, int* status) {
    return (void)stream, *status = fake.capturing, 0;
}
int cuStreamSynchronize(void* stream);
int cuCtxSynchronize(void) {
    return cuStreamSynchronize(NULL);
}
int cuStreamSynchronize(void* stream) {
    (void)stream;
    for (int i = 0; i < queued; ++i) {
        const struct work w = queue[i];
        if (w.kind == 1) fake.signal(w.to);
        if (w.kind == 2) fake.wait(w.to);
        if (w.kind == 3) memcpy((void*)(uintptr_t)w.to, (const void*)(uintptr_t)w.from, w.size);
    }
    return queued = 0, 0;
}
