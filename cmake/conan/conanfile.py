# SPDX-License-Identifier: MIT
# Conan 2: `conan create cmake/conan`.
import os
import re

from conan import ConanFile
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeToolchain
from conan.tools.files import copy, load


class OpenNTC(ConanFile):
    name = "openntc"
    description = "Neural texture compression for any engine and any GPU: headers for C++20, GLSL and HLSL"
    license = "MIT"
    package_type = "header-library"
    settings = "os", "arch", "compiler", "build_type"
    no_copy_source = True

    @property
    def _root(self):
        return os.path.normpath(os.path.join(self.recipe_folder, "..", ".."))

    def set_version(self):
        text = load(self, os.path.join(self._root, "CMakeLists.txt"))
        self.version = re.search(r"project\(openntc VERSION ([0-9.]+)", text).group(1)

    def export_sources(self):
        for pattern in ("include/*", "shaders/*", "schemas/*", "cmake/*", "examples/adapter/*", "CMakeLists.txt", "LICENSE", "THIRD_PARTY.md"):
            copy(self, pattern, self._root, self.export_sources_folder)

    def requirements(self):
        self.requires("rapidjson/cci.20230929", transitive_headers=True)
        self.requires("tl-expected/1.1.0", transitive_headers=True)
        self.requires("glm/1.0.1", transitive_headers=True)

    def package_id(self):
        self.info.clear()

    def validate(self):
        check_min_cppstd(self, 20)

    def generate(self):
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables["OPENNTC_BUILD_TESTS"] = False
        toolchain.cache_variables["OPENNTC_BUILD_EXAMPLES"] = False
        toolchain.cache_variables["OPENNTC_INSTALL"] = True
        for package, variable in (("rapidjson", "RAPIDJSON"), ("tl-expected", "EXPECTED"), ("glm", "GLM")):
            folder = self.dependencies[package].cpp_info.aggregated_components().includedir
            toolchain.cache_variables[f"OPENNTC_{variable}_INCLUDE_DIR"] = folder
        toolchain.generate()

    def package(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.install()

    def package_info(self):
        self.cpp_info.bindirs = []
        self.cpp_info.libdirs = []
        self.cpp_info.includedirs = ["include", "share/openntc/shaders"]
        # The project's own package configuration, which has openntc_add_shaders().
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs = [os.path.join("share", "cmake", "openntc")]
