# What `cmake --install` puts in place: program, library, headers, CMake package, documents, mechanisms; and the Debian
# package made from it (`cpack`).
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/balance)

install(TARGETS balance ${balance_parts} EXPORT balanceTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
if(TARGET balance_app)
  install(TARGETS balance_app RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
include(cmake/PublicHeaders.cmake)
install(DIRECTORY configs DESTINATION ${CMAKE_INSTALL_DATADIR}/balance)
# Where Debian looks for a package's documents. The licence stands in `copyright`, with those of what the page holds.
set(balance_package balance-mechanisms)
set(balance_release 1)
set(balance_contact "The balance authors <nobody@balance-mechanisms.invalid>")
set(document_dir ${CMAKE_INSTALL_DATAROOTDIR}/doc/${balance_package})
install(DIRECTORY docs DESTINATION ${document_dir} PATTERN "__pycache__" EXCLUDE PATTERN ".ipynb_checkpoints" EXCLUDE)
install(FILES README.md CHANGELOG.md cmake/debian/copyright DESTINATION ${document_dir})
if(GZIP_PROGRAM)
  set(changelog ${CMAKE_CURRENT_BINARY_DIR}/changelog.Debian)
  install(
    CODE "execute_process(COMMAND ${CMAKE_COMMAND} -D \"CHANGELOG=${CMAKE_CURRENT_SOURCE_DIR}/CHANGELOG.md\" -D PACKAGE=${balance_package}
      -D VERSION=${PROJECT_VERSION}-${balance_release} -D \"CONTACT=${balance_contact}\" -D \"OUTPUT=${changelog}\" -D \"GZIP=${GZIP_PROGRAM}\"
      -P \"${CMAKE_CURRENT_SOURCE_DIR}/cmake/DebianChangelog.cmake\" COMMAND_ERROR_IS_FATAL ANY)")
  install(FILES ${changelog}.gz DESTINATION ${document_dir})
endif()

if(BALANCE_PYTHON_MODULE)
  set(python_document_dir ${CMAKE_INSTALL_DATAROOTDIR}/doc/python3-${balance_package})
  install(FILES cmake/debian/copyright DESTINATION ${python_document_dir} COMPONENT python)
  if(GZIP_PROGRAM)
    set(python_changelog ${CMAKE_CURRENT_BINARY_DIR}/python/changelog.Debian)
    install(
      CODE "execute_process(COMMAND ${CMAKE_COMMAND} -D \"CHANGELOG=${CMAKE_CURRENT_SOURCE_DIR}/CHANGELOG.md\" -D PACKAGE=python3-${balance_package}
        -D VERSION=${PROJECT_VERSION}-${balance_release} -D \"CONTACT=${balance_contact}\" -D \"OUTPUT=${python_changelog}\" -D \"GZIP=${GZIP_PROGRAM}\"
        -P \"${CMAKE_CURRENT_SOURCE_DIR}/cmake/DebianChangelog.cmake\" COMMAND_ERROR_IS_FATAL ANY)"
      COMPONENT python)
    install(FILES ${python_changelog}.gz DESTINATION ${python_document_dir} COMPONENT python)
  endif()
endif()

install(EXPORT balanceTargets NAMESPACE balance:: DESTINATION ${package_dir})
configure_package_config_file(cmake/balanceConfig.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/balanceConfig.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/balanceConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/balanceConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/balanceConfigVersion.cmake
        DESTINATION ${package_dir})

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME ${balance_package})
set(CPACK_PACKAGE_CONTACT "${balance_contact}")
set(CPACK_DEBIAN_PACKAGE_RELEASE ${balance_release})
string(CONCAT CPACK_PACKAGE_DESCRIPTION
       "From a description of a mechanism, planar or in space, with or without loops, balance derives the conditions of its dynamic\n"
       "balance, designs counterweights, springs and lengths that meet them, and simulates its motion with and without control:\n"
       "torques, reactions, shaking forces and moments. Results are HDF5 files, which are netCDF-4 files as well.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ
                                                WORLD_EXECUTE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# One package of everything but the Python module, one of that.
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_NAME ${balance_package})
set(CPACK_DEBIAN_UNSPECIFIED_DESCRIPTION "${CPACK_PACKAGE_DESCRIPTION}")
# Debian's `balance`, a TCP load balancer, installs a program of the same name.
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_CONFLICTS balance)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_RECOMMENDS gnuplot-nox) # balance plot
if(BALANCE_PYTHON_MODULE)
  math(EXPR python_after "${Python_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-${balance_package})
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.${Python_VERSION_MINOR}~), python3 (<< 3.${python_after}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-xarray, python3-pandas, ${balance_package}")
  string(CONCAT CPACK_DEBIAN_PYTHON_DESCRIPTION
         "The Python module balance_mechanisms: balancing conditions and designs of\n"
         "mechanisms, their torques, reactions and shaking forces, as NumPy arrays\n"
         "and xarray datasets.")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_SOURCE_DIR}/cmake/debian/python/postinst
                                                ${CMAKE_CURRENT_SOURCE_DIR}/cmake/debian/python/prerm)
endif()
string(CONCAT CPACK_DEBIAN_UNSPECIFIED_PACKAGE_SUGGESTS
       "libeigen3-dev, libyaml-cpp-dev, libfmt-dev, nlohmann-json3-dev, libhdf5-dev, libssl-dev, zlib1g-dev, "
       "libnlopt-dev, coinor-libclp-dev, libpugixml-dev")
include(CPack)
