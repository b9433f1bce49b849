// Marks the symbols that the shared library shows; everything else is hidden. Valid C and C++.
#ifndef VOTESS_EXPORT_HPP
#define VOTESS_EXPORT_HPP

#if defined(VOTESS_STATIC)
#define VOTESS_API
#elif defined(_WIN32)
#if defined(VOTESS_BUILDING)
#define VOTESS_API __declspec(dllexport)
#else
#define VOTESS_API __declspec(dllimport)
#endif
#else
#define VOTESS_API __attribute__((visibility("default")))
#endif

#endif
