# One function makes a component: target, alias, headers, warnings, install, export.
#
#   procam_component(<name>
#     [SOURCES file...]          bodies in src/<name>/; none makes a header-only (INTERFACE) target
#     [PUBLIC target...]         what the public headers include
#     [PRIVATE target...]        what only the bodies include
#     [DEFINES name...]          macros that the bodies and whoever includes the headers see
#     [FIND "Eigen3 3.4" ...]    packages that find_package(procam COMPONENTS <name>) must find first
#     [FIND_PRIVATE ...])        the same for what only the bodies include: static libraries alone need them
#
# Target procam_<name>, alias procam::<name>, headers include/procam/<name>/; installed as a component of the CMake package
# and as procam-<name>.pc.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

add_library(procam_warnings INTERFACE)
# In a unity build GCC takes each source for a header, in which no type should use the anonymous namespace.
target_compile_options(procam_warnings INTERFACE
  $<$<CXX_COMPILER_ID:GNU,Clang,AppleClang>:-Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor>
  $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>
  $<$<AND:$<BOOL:${PROCAM_WERROR}>,$<CXX_COMPILER_ID:GNU,Clang,AppleClang>>:-Werror>)
if(PROCAM_SANITIZE)
  add_compile_options(-fsanitize=${PROCAM_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  # GCC cannot follow values through the checks it inserts and warns of initialised ones (its manual says so).
  target_compile_options(procam_warnings INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  add_link_options(-fsanitize=${PROCAM_SANITIZE})
endif()

# Unoptimised code compiles in half the time or less. For builds that are tested and not installed (preset ci).
set(PROCAM_UNOPTIMISED "" CACHE STRING
  "What to compile without optimisation: \"tests\", \"examples\", \"tools\", \"python\", \"bench\"")

# Compiles a program without optimisation where PROCAM_UNOPTIMISED names its group. A template has instances in many objects,
# and the linker takes the first: the libraries' objects come before the program's, so that optimised instances are used.
# HEADERS, which most of the group's programs include, are parsed once: by Clang alone, as GCC demands the same macros of all.
function(procam_unoptimised target group)
  cmake_parse_arguments(arg "" "" "HEADERS;HEADERS_LINK" ${ARGN})
  if(NOT group IN_LIST PROCAM_UNOPTIMISED)
    return()
  endif()
  target_compile_options(${target} PRIVATE -O0)
  if(arg_HEADERS AND CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    if(NOT TARGET procam_headers_${group})
      file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/headers_${group}.cpp CONTENT "")
      add_library(procam_headers_${group} OBJECT ${CMAKE_CURRENT_BINARY_DIR}/headers_${group}.cpp)
      target_link_libraries(procam_headers_${group} PRIVATE ${arg_HEADERS_LINK} procam_warnings)
      target_compile_options(procam_headers_${group} PRIVATE -O0)
      target_precompile_headers(procam_headers_${group} PRIVATE ${arg_HEADERS})
    endif()
    target_precompile_headers(${target} REUSE_FROM procam_headers_${group})
  endif()
  get_target_property(open ${target} LINK_LIBRARIES)
  set(seen)
  while(open)
    list(POP_FRONT open library)
    if(NOT library MATCHES "^procam::" OR library IN_LIST seen)
      continue()
    endif()
    list(APPEND seen ${library})
    get_target_property(component ${library} ALIASED_TARGET)
    get_target_property(type ${component} TYPE)
    if(type STREQUAL "STATIC_LIBRARY")
      target_sources(${target} PRIVATE $<TARGET_OBJECTS:${component}>)
      get_target_property(more ${component} LINK_LIBRARIES)
    else()
      get_target_property(more ${component} INTERFACE_LINK_LIBRARIES)
    endif()
    if(more)
      list(APPEND open ${more})
    endif()
  endwhile()
endfunction()

function(procam_component name)
  cmake_parse_arguments(arg "" "" "SOURCES;PUBLIC;PRIVATE;DEFINES;FIND;FIND_PRIVATE" ${ARGN})
  set(target procam_${name})
  if(arg_SOURCES)
    add_library(${target} ${arg_SOURCES})
    set(scope PUBLIC)
    target_link_libraries(${target} PRIVATE ${arg_PRIVATE} $<BUILD_INTERFACE:procam_warnings>)
    # The ABI may change with every 0.y (docs/stability.md). Symbols are hidden unless marked PROCAM_EXPORT
    # (core/base/export.hpp), in static libraries as well: one set of objects serves both.
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON VERSION ${PROJECT_VERSION}
      SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} CXX_VISIBILITY_PRESET hidden
      VISIBILITY_INLINES_HIDDEN ON DEFINE_SYMBOL "")
    if(BUILD_SHARED_LIBS AND NOT PROCAM_SANITIZE)
      target_link_options(${target} PRIVATE LINKER:-z,defs)  # a symbol that no library exports is an error here, not in a program
    endif()
  else()
    add_library(${target} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(procam::${name} ALIAS ${target})
  target_compile_features(${target} ${scope} cxx_std_17)
  target_include_directories(${target} ${scope}
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(${target} ${scope} ${arg_PUBLIC})
  target_compile_definitions(${target} ${scope} ${arg_DEFINES})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  if(NOT PROCAM_INSTALL)
    return()
  endif()

  install(TARGETS ${target} EXPORT procam-${name}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
  # A backend (render_gl) has its header in the folder of the component that it draws for.
  if(IS_DIRECTORY ${PROJECT_SOURCE_DIR}/include/procam/${name})
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/procam/${name} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/procam)
    install(FILES ${PROJECT_SOURCE_DIR}/include/procam/${name}.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/procam)
  endif()
  install(EXPORT procam-${name} NAMESPACE procam:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/procam)

  # What the package file needs to know: the components below this one, and the packages it asks for.
  set(packages ${arg_FIND})
  if(NOT BUILD_SHARED_LIBS)
    list(APPEND packages ${arg_FIND_PRIVATE})
  endif()
  set(components)
  foreach(link IN LISTS arg_PUBLIC arg_PRIVATE)
    if(link MATCHES "^procam::(.+)$")
      list(APPEND components ${CMAKE_MATCH_1})
    endif()
  endforeach()
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/procam-${name}-needs.cmake @ONLY CONTENT
"set(procam_@name@_NEEDS @components@)\nset(procam_@name@_PACKAGES \"@packages@\")\n")
  install(FILES ${PROJECT_BINARY_DIR}/procam-${name}-needs.cmake
    DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/procam)
  procam_pkg_config(${name} SOURCES "${arg_SOURCES}" DEFINES "${arg_DEFINES}" PUBLIC ${arg_PUBLIC} PRIVATE ${arg_PRIVATE})
endfunction()

# procam-<name>.pc; see below for what it holds. A link without a row here is an error, so that none is forgotten.
function(procam_pkg_config name)
  cmake_parse_arguments(arg "" "SOURCES;DEFINES" "PUBLIC;PRIVATE" ${ARGN})
  set(requires)
  set(requires_private)
  set(libs)
  set(libs_private)
  foreach(scope PUBLIC PRIVATE)
    # A static library needs at the link what its bodies use.
    set(suffix)
    if(scope STREQUAL "PRIVATE" AND BUILD_SHARED_LIBS)
      set(suffix _private)
    endif()
    foreach(link IN LISTS arg_${scope})
      if(link MATCHES "^procam::(.+)$")
        list(APPEND requires${suffix} "procam-${CMAKE_MATCH_1} = ${PROJECT_VERSION}")
      elseif(link STREQUAL "Eigen3::Eigen")
        list(APPEND requires${suffix} "eigen3 >= 3.4")
      elseif(link STREQUAL "Ceres::ceres")
        list(APPEND libs${suffix} -lceres -lglog)
      elseif(link STREQUAL "pugixml::pugixml")
        list(APPEND requires${suffix} "pugixml >= 1.13")
      elseif(link STREQUAL "glfw")
        list(APPEND requires${suffix} "glfw3 >= 3.3")
      elseif(link STREQUAL "OpenGL::GL")
        list(APPEND libs${suffix} -lGL)
      elseif(link STREQUAL "CycloneDDS::ddsc")
        list(APPEND libs${suffix} -lddsc)
      elseif(link STREQUAL "Threads::Threads")
        list(APPEND libs${suffix} -pthread)
      elseif(link MATCHES "^opencv_" OR link MATCHES "^[a-z]+$")
        list(APPEND libs${suffix} -l${link})
      elseif(link MATCHES "^/")
        list(APPEND libs${suffix} ${link})
      elseif(NOT link MATCHES "^\\$<BUILD_INTERFACE:")
        message(FATAL_ERROR "procam-${name}.pc: no row in ProcamComponent.cmake for ${link}")
      endif()
    endforeach()
  endforeach()
  if(arg_SOURCES)
    list(PREPEND libs -L\${libdir} -lprocam_${name})
  endif()
  foreach(list requires requires_private)
    list(JOIN ${list} ", " ${list})
  endforeach()
  set(defines ${arg_DEFINES})
  list(TRANSFORM defines PREPEND " -D")
  list(JOIN defines "" defines)
  foreach(list libs libs_private)
    list(JOIN ${list} " " ${list})
  endforeach()
  file(RELATIVE_PATH to_prefix /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
  string(REGEX REPLACE "/$" "" to_prefix ${to_prefix})
  set(module procam-${name})
  if(name STREQUAL "procam")
    set(module procam)
  endif()
  configure_file(${PROJECT_SOURCE_DIR}/cmake/procam.pc.in ${PROJECT_BINARY_DIR}/${module}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${module}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endfunction()

function(procam_install_package)
  configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/procamConfig.cmake.in
    ${PROJECT_BINARY_DIR}/procamConfig.cmake INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/procam)
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/procamConfigVersion.cmake COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/procamConfig.cmake ${PROJECT_BINARY_DIR}/procamConfigVersion.cmake
    DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/procam)
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CITATION.cff ${PROJECT_SOURCE_DIR}/CHANGELOG.md
    DESTINATION ${CMAKE_INSTALL_DOCDIR})
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs ${PROJECT_SOURCE_DIR}/examples DESTINATION ${CMAKE_INSTALL_DOCDIR}
    PATTERN docs/site EXCLUDE PATTERN __pycache__ EXCLUDE)
  install(FILES ${PROJECT_SOURCE_DIR}/package.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/procam)
endfunction()

# A stage's tests: tests/<name>/*.cpp become one program, each TEST its own ctest entry "<name>.Suite.Test".
# SLOW, LONG, FIRST and ALONE are patterns of GoogleTest's filter that share no test. SLOW and LONG label those that take minutes
# under sanitizers and those that take minutes anywhere: `ctest -LE "slow|long"` omits both, tests/run.sh leaves the latter
# to `ctest -L long`. (One label each: gtest_discover_tests() drops the second of a list.) FIRST are begun before all
# others: they take minutes, and little of a core. ALONE run beside no other test: they look at the time of each frame.
# OPTIMISED are those that compute images or solve themselves: without, they would take longer than their compilation.
# BRIEF are programs whose tests take milliseconds each: with PROCAM_TEST_SHARDS=n, n entries "<name>.<i>_of_<n>" run their tests
# (GoogleTest's sharding), as OpenCV's libraries take 0.1 to 0.2 s to load.
set(PROCAM_TEST_SHARDS 0 CACHE STRING "Run the programs of brief tests by so many ctest entries each; 0: an entry for each test")
function(procam_test name)
  cmake_parse_arguments(arg "OPTIMISED;BRIEF" "SLOW;LONG;FIRST;ALONE" "SOURCES;LINK" ${ARGN})
  add_executable(test_${name} ${arg_SOURCES})
  target_link_libraries(test_${name} PRIVATE ${arg_LINK} procam_warnings procam_test_support)
  if(NOT arg_OPTIMISED)
    procam_unoptimised(test_${name} tests HEADERS <gtest/gtest.h> <procam/core.hpp> HEADERS_LINK procam_test_support)
  endif()
  set(discovery TEST_PREFIX ${name}. DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60)
  foreach(seconds 600 1500 3000)
    set(seconds_${seconds} ${seconds})
    if(PROCAM_SANITIZE)
      math(EXPR seconds_${seconds} "6 * ${seconds}")
    endif()
  endforeach()
  set(others ${arg_SLOW} ${arg_LONG} ${arg_FIRST} ${arg_ALONE})
  list(JOIN others ":" others)
  if(arg_BRIEF AND PROCAM_TEST_SHARDS GREATER 0)
    foreach(shard RANGE 1 ${PROCAM_TEST_SHARDS})
      math(EXPR index "${shard} - 1")
      set(entry ${name}.${shard}_of_${PROCAM_TEST_SHARDS})
      add_test(NAME ${entry} COMMAND test_${name} --gtest_filter=-${others})
      set_tests_properties(${entry} PROPERTIES TIMEOUT ${seconds_1500}
        ENVIRONMENT "GTEST_TOTAL_SHARDS=${PROCAM_TEST_SHARDS};GTEST_SHARD_INDEX=${index}")
    endforeach()
  elseif(others)
    gtest_discover_tests(test_${name} ${discovery} TEST_FILTER "-${others}" PROPERTIES TIMEOUT ${seconds_600})
  else()
    gtest_discover_tests(test_${name} ${discovery} PROPERTIES TIMEOUT ${seconds_600})
  endif()
  if(arg_SLOW)
    gtest_discover_tests(test_${name} ${discovery} TEST_FILTER "${arg_SLOW}" PROPERTIES TIMEOUT ${seconds_1500} LABELS slow)
  endif()
  if(arg_LONG)
    gtest_discover_tests(test_${name} ${discovery} TEST_FILTER "${arg_LONG}" PROPERTIES TIMEOUT ${seconds_3000} LABELS long)
  endif()
  if(arg_FIRST)
    gtest_discover_tests(test_${name} ${discovery} TEST_FILTER "${arg_FIRST}" PROPERTIES TIMEOUT ${seconds_3000} COST 1000)
  endif()
  if(arg_ALONE)
    gtest_discover_tests(test_${name} ${discovery} TEST_FILTER "${arg_ALONE}" PROPERTIES TIMEOUT ${seconds_600} RUN_SERIAL TRUE)
  endif()
endfunction()
