# Compiles a shader and writes BASE.spv, BASE.cpp with its words and BASE.d with the files it was made from.
# Run by votess_shader with NAME, SOURCE, BASE, DEFINES, INCLUDE, GLSLANG and, where there is one, SPIRV_VAL.
cmake_minimum_required(VERSION 3.25)

# Runs a command and fails with it. Shows its output, except lines that only name the source.
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE result OUTPUT_VARIABLE text ERROR_VARIABLE text)
  string(REPLACE "${SOURCE}\n" "" text "${text}")
  string(STRIP "${text}" text)
  if(text)
    message("${text}")
  endif()
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "Shader ${NAME} (${SOURCE}): failed with ${result}")
  endif()
endfunction()

cmake_path(GET BASE PARENT_PATH folder)
file(MAKE_DIRECTORY ${folder})
list(TRANSFORM DEFINES PREPEND "-D")
cmake_path(GET SOURCE EXTENSION LAST_ONLY stage)  # .comp, .vert or .frag
string(SUBSTRING ${stage} 1 -1 stage)
run(${GLSLANG} -V -S ${stage} --target-env vulkan1.1 -I${INCLUDE} ${DEFINES} --depfile ${BASE}.d -o ${BASE}.spv ${SOURCE})
if(SPIRV_VAL)
  run(${SPIRV_VAL} --target-env vulkan1.1 ${BASE}.spv)
endif()

# The build system knows the .cpp, not the .spv.
file(READ ${BASE}.d dependencies)
string(REGEX REPLACE "^[^:]*:" "${BASE}.cpp:" dependencies "${dependencies}")
file(WRITE ${BASE}.d "${dependencies}")

file(READ ${BASE}.spv words HEX)
string(REGEX REPLACE "(..)(..)(..)(..)" "0x\\4\\3\\2\\1," words "${words}")
string(REGEX REPLACE "(0x[^,]*,0x[^,]*,0x[^,]*,0x[^,]*,0x[^,]*,0x[^,]*,0x[^,]*,0x[^,]*,)" "    \\1\n" words "${words}")
file(WRITE ${BASE}.cpp "// The shader ${NAME}, made by embed.cmake.
#include <cstdint>
#include <span>

namespace votess::gpu::shaders {

static constexpr std::uint32_t words[] = {
${words}
};

extern const std::span<const std::uint32_t> ${NAME};
constinit const std::span<const std::uint32_t> ${NAME}(words);

}  // namespace votess::gpu::shaders
")
