# The installed package: both programs, rro_add_library for projects that build object libraries (rroAddLibrary.cmake), and
# the libraries rro::format and rro::solver with their headers (samples/programs/README.md).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(RRO_PACKAGE_FOLDER ${CMAKE_INSTALL_LIBDIR}/cmake/rro)
set(RRO_INCLUDE_FOLDER ${CMAKE_INSTALL_INCLUDEDIR}/rro)

install(TARGETS rro-compile rro-solve EXPORT rroTargets RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(EXPORT rroTargets NAMESPACE rro:: DESTINATION ${RRO_PACKAGE_FOLDER})

# What the solver's library stands on comes along; those names are nobody's but ours.
set(RRO_LIBRARIES rro_format rro_solver rro_rays rro_tool rro_scene rro_visibility rro_output rro_study rro_transport rro_factors
                  rro_effects)
set_target_properties(rro_format PROPERTIES EXPORT_NAME format)
set_target_properties(rro_solver PROPERTIES EXPORT_NAME solver)
target_include_directories(rro_format INTERFACE $<INSTALL_INTERFACE:${RRO_INCLUDE_FOLDER}>)
target_compile_features(rro_format INTERFACE $<INSTALL_INTERFACE:cxx_std_20>)
target_compile_options(rro_format INTERFACE "$<INSTALL_INTERFACE:${RRO_NUMERICS}>")
if(RRO_SANITIZE)
  target_link_options(rro_format INTERFACE $<INSTALL_INTERFACE:-fsanitize=${RRO_SANITIZE}>)
endif()
install(TARGETS ${RRO_LIBRARIES} EXPORT rroLibraries ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT rroLibraries NAMESPACE rro:: DESTINATION ${RRO_PACKAGE_FOLDER})
install(DIRECTORY format solver DESTINATION ${RRO_INCLUDE_FOLDER} FILES_MATCHING PATTERN "*.h"
        PATTERN tool EXCLUDE PATTERN edit EXCLUDE PATTERN tradeoff EXCLUDE)
install(FILES ${CMAKE_BINARY_DIR}/generated/format/version.h DESTINATION ${RRO_INCLUDE_FOLDER}/format)
install(FILES ${CMAKE_BINARY_DIR}/generated/solver/scene/chosen.h DESTINATION ${RRO_INCLUDE_FOLDER}/solver/scene)

configure_package_config_file(compiler/cmake/rroConfig.cmake.in ${CMAKE_BINARY_DIR}/generated/rroConfig.cmake
                              INSTALL_DESTINATION ${RRO_PACKAGE_FOLDER})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/generated/rroConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/generated/rroConfig.cmake ${CMAKE_BINARY_DIR}/generated/rroConfigVersion.cmake
              compiler/cmake/rroAddLibrary.cmake
        DESTINATION ${RRO_PACKAGE_FOLDER})
