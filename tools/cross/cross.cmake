# The toolchain of another system. The environment names the system and the folder with the compiler's programs.
set(CMAKE_SYSTEM_NAME $ENV{CROSS_SYSTEM})
set(CMAKE_SYSTEM_PROCESSOR $ENV{CROSS_PROCESSOR})
if(CMAKE_SYSTEM_NAME STREQUAL Darwin)
  set(CMAKE_SYSTEM_VERSION 20)  # macOS 11
  # CMake sets these on macOS alone.
  set(CMAKE_SHARED_LIBRARY_RUNTIME_CXX_FLAG -Wl,-rpath,)
  set(CMAKE_INSTALL_NAME_DIR @rpath)
endif()
set(folder $ENV{CROSS_FOLDER})
set(CMAKE_C_COMPILER ${folder}/cc)
set(CMAKE_CXX_COMPILER ${folder}/c++)
set(CMAKE_AR ${folder}/ar)
set(CMAKE_RANLIB ${folder}/ranlib)
set(CMAKE_FIND_ROOT_PATH ${folder})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
foreach(kind LIBRARY INCLUDE PACKAGE)
  set(CMAKE_FIND_ROOT_PATH_MODE_${kind} ONLY)
endforeach()
# No tool changes them afterwards.
set(CMAKE_BUILD_WITH_INSTALL_RPATH ON)
set(CMAKE_BUILD_WITH_INSTALL_NAME_DIR ON)
