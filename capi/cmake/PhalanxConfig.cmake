# find_package(Phalanx) with Phalanx_DIR or CMAKE_PREFIX_PATH set to this folder: the target Phalanx::phalanx.
#
# The library is looked for where `cargo build --release -p capi` puts it, and where the variable PHALANX_LIBRARY says.
get_filename_component(_phalanx_capi "${CMAKE_CURRENT_LIST_DIR}/.." ABSOLUTE)

if(NOT PHALANX_LIBRARY AND DEFINED ENV{PHALANX_LIBRARY})
    set(PHALANX_LIBRARY "$ENV{PHALANX_LIBRARY}")
endif()
find_library(PHALANX_LIBRARY NAMES phalanx HINTS "${_phalanx_capi}/../target/release"
    DOC "The shared library of Phalanx, libphalanx.so")

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Phalanx
    REQUIRED_VARS PHALANX_LIBRARY
    REASON_FAILURE_MESSAGE "build it with: cargo build --release -p capi")

if(Phalanx_FOUND AND NOT TARGET Phalanx::phalanx)
    add_library(Phalanx::phalanx SHARED IMPORTED)
    set_target_properties(Phalanx::phalanx PROPERTIES
        IMPORTED_LOCATION "${PHALANX_LIBRARY}"
        IMPORTED_NO_SONAME TRUE
        INTERFACE_INCLUDE_DIRECTORIES "${_phalanx_capi}/include")
endif()
