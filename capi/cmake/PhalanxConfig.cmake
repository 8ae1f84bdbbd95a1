# find_package(Phalanx): the target Phalanx::phalanx. Works from where it lies in
#
#     a checkout               capi/cmake                the library from `cargo build --release -p capi`
#     the Python package       phalanx/cmake             phalanx/libphalanx.so
#     an installation          lib/cmake/Phalanx         lib/libphalanx.so
#
# The variable PHALANX_LIBRARY, of CMake or of the environment, names another library.
if(NOT PHALANX_LIBRARY AND DEFINED ENV{PHALANX_LIBRARY})
    set(PHALANX_LIBRARY "$ENV{PHALANX_LIBRARY}")
endif()
find_library(PHALANX_LIBRARY NAMES phalanx
    HINTS "${CMAKE_CURRENT_LIST_DIR}/../../target/release" "${CMAKE_CURRENT_LIST_DIR}/.." "${CMAKE_CURRENT_LIST_DIR}/../.."
    DOC "The shared library of Phalanx, libphalanx.so")
find_path(PHALANX_INCLUDE_DIRECTORY NAMES phalanx.h NO_DEFAULT_PATH
    HINTS "${CMAKE_CURRENT_LIST_DIR}/../include" "${CMAKE_CURRENT_LIST_DIR}/../../../include"
    DOC "The folder of phalanx.h and phalanx.hpp")

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Phalanx
    REQUIRED_VARS PHALANX_LIBRARY PHALANX_INCLUDE_DIRECTORY
    REASON_FAILURE_MESSAGE "in a checkout, build it with: cargo build --release -p capi")

if(Phalanx_FOUND AND NOT TARGET Phalanx::phalanx)
    add_library(Phalanx::phalanx SHARED IMPORTED)
    # A library from Cargo has no soname, an installed one has.
    set_target_properties(Phalanx::phalanx PROPERTIES
        IMPORTED_LOCATION "${PHALANX_LIBRARY}"
        IMPORTED_NO_SONAME TRUE
        INTERFACE_INCLUDE_DIRECTORIES "${PHALANX_INCLUDE_DIRECTORY}")
endif()
