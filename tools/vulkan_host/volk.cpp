// The host's own volk, under its usual names.
#define VOLK_IMPLEMENTATION
#include <volk.h>
