# One function makes a component: target, alias, headers, warnings, install, export.
#
#   procam_component(<name>
#     [SOURCES file...]          bodies in src/<name>/; none makes a header-only (INTERFACE) target
#     [PUBLIC target...]         what the public headers include
#     [PRIVATE target...]        what only the bodies include
#     [FIND "Eigen3 3.4" ...])   packages that find_package(procam COMPONENTS <name>) must find first
#
# Target procam_<name>, alias procam::<name>, headers include/procam/<name>/.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

add_library(procam_warnings INTERFACE)
target_compile_options(procam_warnings INTERFACE
  $<$<CXX_COMPILER_ID:GNU,Clang,AppleClang>:-Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor>
  $<$<AND:$<BOOL:${PROCAM_WERROR}>,$<CXX_COMPILER_ID:GNU,Clang,AppleClang>>:-Werror>)
if(PROCAM_SANITIZE)
  add_compile_options(-fsanitize=${PROCAM_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  # GCC cannot follow values through the checks it inserts and warns of initialised ones (its manual says so).
  target_compile_options(procam_warnings INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  add_link_options(-fsanitize=${PROCAM_SANITIZE})
endif()

function(procam_component name)
  cmake_parse_arguments(arg "" "" "SOURCES;PUBLIC;PRIVATE;FIND" ${ARGN})
  set(target procam_${name})
  if(arg_SOURCES)
    add_library(${target} ${arg_SOURCES})
    set(scope PUBLIC)
    target_link_libraries(${target} PRIVATE ${arg_PRIVATE} $<BUILD_INTERFACE:procam_warnings>)
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  else()
    add_library(${target} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(procam::${name} ALIAS ${target})
  target_compile_features(${target} ${scope} cxx_std_17)
  target_include_directories(${target} ${scope}
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(${target} ${scope} ${arg_PUBLIC})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})

  install(TARGETS ${target} EXPORT procam-${name}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
  # A backend (render_gl) has its header in the folder of the component that it draws for.
  if(IS_DIRECTORY ${PROJECT_SOURCE_DIR}/include/procam/${name})
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/procam/${name} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/procam)
    install(FILES ${PROJECT_SOURCE_DIR}/include/procam/${name}.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/procam)
  endif()
  install(EXPORT procam-${name} NAMESPACE procam:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/procam)

  # What the package file needs to know: the components below this one, and the packages it asks for.
  set(components)
  foreach(link IN LISTS arg_PUBLIC arg_PRIVATE)
    if(link MATCHES "^procam::(.+)$")
      list(APPEND components ${CMAKE_MATCH_1})
    endif()
  endforeach()
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/procam-${name}-needs.cmake @ONLY CONTENT
"set(procam_@name@_NEEDS @components@)\nset(procam_@name@_PACKAGES \"@arg_FIND@\")\n")
  install(FILES ${PROJECT_BINARY_DIR}/procam-${name}-needs.cmake
    DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/procam)
endfunction()

function(procam_install_package)
  configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/procamConfig.cmake.in
    ${PROJECT_BINARY_DIR}/procamConfig.cmake INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/procam)
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/procamConfigVersion.cmake COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/procamConfig.cmake ${PROJECT_BINARY_DIR}/procamConfigVersion.cmake
    DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/procam)
endfunction()

# A stage's tests: tests/<name>/*.cpp become one program, each TEST its own ctest entry "<name>.Suite.Test".
# SLOW, LONG and FIRST are patterns of GoogleTest's filter that share no test. SLOW and LONG label those that take minutes
# under sanitizers and those that take minutes anywhere: `ctest -LE "slow|long"` omits both, tests/run.sh leaves the latter
# to `ctest -L long`. (One label each: gtest_discover_tests() drops the second of a list.) FIRST are begun before all
# others: they take minutes, and little of a core.
function(procam_test name)
  cmake_parse_arguments(arg "" "SLOW;LONG;FIRST" "SOURCES;LINK" ${ARGN})
  add_executable(test_${name} ${arg_SOURCES})
  target_link_libraries(test_${name} PRIVATE ${arg_LINK} procam_warnings procam_test_support)
  set(discovery TEST_PREFIX ${name}. DISCOVERY_MODE PRE_TEST)
  set(others ${arg_SLOW} ${arg_LONG} ${arg_FIRST})
  if(others)
    list(JOIN others ":" others)
    gtest_discover_tests(test_${name} ${discovery} TEST_FILTER "-${others}" PROPERTIES TIMEOUT 600)
  else()
    gtest_discover_tests(test_${name} ${discovery} PROPERTIES TIMEOUT 600)
  endif()
  if(arg_SLOW)
    gtest_discover_tests(test_${name} ${discovery} TEST_FILTER "${arg_SLOW}" PROPERTIES TIMEOUT 1500 LABELS slow)
  endif()
  if(arg_LONG)
    gtest_discover_tests(test_${name} ${discovery} TEST_FILTER "${arg_LONG}" PROPERTIES TIMEOUT 3000 LABELS long)
  endif()
  if(arg_FIRST)
    gtest_discover_tests(test_${name} ${discovery} TEST_FILTER "${arg_FIRST}" PROPERTIES TIMEOUT 3000 COST 1000)
  endif()
endfunction()
