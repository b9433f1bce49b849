"""votess for Conan 2, from the source tree around this file:

    conan create tools/recipes/conan -s compiler.cppstd=20

It needs no package of Conan. With the option with_vulkan, Vulkan's headers, volk, GLM and glslang are those of the
system, see third_party/README.md. -o "votess/*:with_vulkan=False" builds the CPU engine alone, without them.
"""

import re
from pathlib import Path

from conan import ConanFile
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeToolchain, cmake_layout
from conan.tools.files import copy, load, rmdir
from conan.tools.system.package_manager import Apt

required_conan_version = ">=2.0"


class VotessRecipe(ConanFile):
    name = "votess"
    description = "Exact 3D and 2D Voronoi tessellation on any GPU and any CPU"
    license = "BSD-3-Clause"
    topics = ("voronoi", "delaunay", "power-diagram", "tessellation", "computational-geometry", "vulkan")
    package_type = "library"
    settings = "os", "arch", "compiler", "build_type"
    options = {"shared": [True, False], "fPIC": [True, False], "with_vulkan": [True, False]}
    default_options = {"shared": True, "fPIC": True, "with_vulkan": True}
    implements = ["auto_shared_fpic"]

    def _root(self):
        return Path(self.recipe_folder).parents[2]

    def set_version(self):
        text = load(self, self._root() / "CMakeLists.txt")
        self.version = re.search(r"project\(votess VERSION ([0-9.]+)", text).group(1)

    def export_sources(self):
        copy(self, "CMakeLists.txt", self._root(), self.export_sources_folder)
        copy(self, "LICENSE", self._root(), self.export_sources_folder)
        for folder in ("engine", "include", "shaders", "third_party"):
            copy(self, f"{folder}/*", self._root(), self.export_sources_folder)

    def layout(self):
        cmake_layout(self)

    def system_requirements(self):
        # With apt, Conan names missing packages; it installs them only if its configuration allows that.
        Apt(self).install(["libeigen3-dev"])
        if self.options.with_vulkan:
            Apt(self).install(["libvulkan-dev", "libvulkan-volk-dev", "libglm-dev", "glslang-tools"])

    def validate(self):
        check_min_cppstd(self, 20)

    def generate(self):
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables["VOTESS_BUILD_VULKAN"] = bool(self.options.with_vulkan)
        for part in ("CLI", "TESTS", "BENCH"):
            toolchain.cache_variables[f"VOTESS_BUILD_{part}"] = False
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()
        copy(self, "LICENSE", self.source_folder, Path(self.package_folder) / "licenses")
        # Conan writes files of its own for CMake and pkg-config.
        rmdir(self, Path(self.package_folder) / "lib" / "cmake")
        rmdir(self, Path(self.package_folder) / "lib" / "pkgconfig")

    def package_info(self):
        self.cpp_info.set_property("cmake_file_name", "votess")
        self.cpp_info.set_property("cmake_target_name", "votess::votess")
        self.cpp_info.set_property("pkg_config_name", "votess")
        self.cpp_info.libs = ["votess"]
        if not self.options.shared:
            self.cpp_info.defines = ["VOTESS_STATIC"]
            if self.settings.os in ("Linux", "FreeBSD"):
                self.cpp_info.system_libs = ["pthread", "dl", "m"]
