# Foreign libraries. balanceConfig.cmake.in names the same ones for whoever links the installed library.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(yaml-cpp 0.7 REQUIRED)
find_package(fmt 9 REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(muparser REQUIRED)
find_package(HDF5 1.10 REQUIRED COMPONENTS C HL)
foreach(library IN LISTS HDF5_C_LIBRARIES)
  # Debian keeps links to HDF5 in a folder of their own; the libraries themselves lie where the loader looks.
  file(REAL_PATH "${library}" found)
  cmake_path(GET found PARENT_PATH found)
  cmake_path(GET library PARENT_PATH link)
  if(found IN_LIST CMAKE_CXX_IMPLICIT_LINK_DIRECTORIES)
    list(APPEND CMAKE_CXX_IMPLICIT_LINK_DIRECTORIES ${link})
  endif()
endforeach()
find_package(ZLIB REQUIRED)
find_package(OpenSSL 3 REQUIRED COMPONENTS Crypto)
find_package(PkgConfig REQUIRED)
pkg_check_modules(nlopt REQUIRED IMPORTED_TARGET nlopt)
pkg_check_modules(clp REQUIRED IMPORTED_TARGET clp)
find_package(CLI11 2.1 REQUIRED)
find_package(Boost 1.74 REQUIRED) # headers only: Odeint

set(balance_private_libraries yaml-cpp muparser::muparser hdf5::hdf5 hdf5::hdf5_hl fmt::fmt
                              nlohmann_json::nlohmann_json OpenSSL::Crypto ZLIB::ZLIB PkgConfig::nlopt PkgConfig::clp)
set(balance_app_libraries CLI11::CLI11 fmt::fmt nlohmann_json::nlohmann_json)
