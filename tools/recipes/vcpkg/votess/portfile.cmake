# votess for vcpkg, as an overlay port that builds the source tree around it:
#
#     vcpkg install votess --overlay-ports=WHERE_VOTESS_IS/tools/recipes/vcpkg
#
# vcpkg does not see changes of the tree: --no-binarycaching after `vcpkg remove votess` builds again. The port follows
# vcpkg's documentation; the tests have no vcpkg and do not run it.
get_filename_component(SOURCE_PATH "${CURRENT_PORT_DIR}/../../../.." ABSOLUTE)

vcpkg_check_features(OUT_FEATURE_OPTIONS feature_options FEATURES vulkan VOTESS_BUILD_VULKAN)
vcpkg_cmake_configure(
    SOURCE_PATH "${SOURCE_PATH}"
    OPTIONS
        ${feature_options}
        -DVOTESS_BUILD_CLI=OFF
        -DVOTESS_BUILD_TESTS=OFF
        -DVOTESS_BUILD_BENCH=OFF
        # glslang, which compiles the shaders, is a program of the machine that builds.
        "-DCMAKE_PROGRAM_PATH=${CURRENT_HOST_INSTALLED_DIR}/tools/glslang"
)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/votess)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
