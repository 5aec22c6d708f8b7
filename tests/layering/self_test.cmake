# Proves that check.cmake can fail: one small tree for each rule, and one that keeps them all.
#   cmake -DSCRATCH=<folder> -P self_test.cmake
cmake_minimum_required(VERSION 3.22)
set(check ${CMAKE_CURRENT_LIST_DIR}/check.cmake)

function(expect name file include_line verdict)
  file(REMOVE_RECURSE ${SCRATCH})
  file(WRITE ${SCRATCH}/${file} "#pragma once\n${include_line}\n")
  execute_process(COMMAND ${CMAKE_COMMAND} -DROOT=${SCRATCH} -P ${check}
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  string(REGEX REPLACE "[ \n]+" " " output "${output}")
  string(FIND "${output}" "${verdict}" position)
  if(position EQUAL -1 OR (verdict MATCHES "keep to the arrows" AND NOT result EQUAL 0)
      OR (NOT verdict MATCHES "keep to the arrows" AND result EQUAL 0))
    message(FATAL_ERROR "${name}: expected '${verdict}', got (${result}):\n${output}")
  endif()
endfunction()

expect(allowed src/simulate/world.cpp "#include \"procam/pattern/draw.hpp\"" "1 files keep to the arrows")
expect(ceres_beside_the_costs include/procam/calibrate/costs/pixel.hpp "#include <ceres/jet.h>"
  "1 files keep to the arrows")
expect(heavy_package_in_a_body src/io/read.cpp "#include <opencv2/core.hpp>" "1 files keep to the arrows")
expect(stage_to_stage src/surface/join.cpp "#include \"procam/detect/chessboard.hpp\"" "surface may not include detect")
expect(against_the_stream include/procam/core/rig/rig.hpp "#  include <procam/io/rig_file.hpp>"
  "core may not include io")
expect(opencv_in_public include/procam/detect/chessboard.hpp "#include <opencv2/core.hpp>"
  "a public header may not include opencv2/core.hpp")
expect(json_in_public include/procam/io/rig_file.hpp "#include <nlohmann/json_fwd.hpp>"
  "a public header may not include nlohmann/json_fwd.hpp")
expect(pugixml_in_public include/procam/io/rig_file.hpp "#include <pugixml.hpp>"
  "a public header may not include pugixml.hpp")
expect(window_in_public include/procam/device/frame_sink.hpp "#include <GLFW/glfw3.h>"
  "a public header may not include GLFW/glfw3.h")
expect(gl_in_public include/procam/render/gl.hpp "#include <epoxy/gl.h>"
  "a public header may not include epoxy/gl.h")
expect(ceres_outside_the_costs include/procam/calibrate/bundle.hpp "#include <ceres/problem.h>"
  "a public header may not include ceres/problem.h")
expect(core_with_more_than_eigen include/procam/core/geometry/ray.hpp "#include <fmt/format.h>"
  "core needs Eigen alone")
expect(side_door src/surface/join.cpp "#include \"../detect/corners.hpp\"" "reaches into another folder")
expect(unknown_stage src/misc/join.cpp "#include <vector>" "stage 'misc' has no arrows")
file(REMOVE_RECURSE ${SCRATCH})

# Tools, beside one good file.
function(expect_tool name lines verdict)
  string(REPEAT "\n" ${lines} padding)
  expect(${name} src/io/read.cpp "#include <string>" "1 files keep to the arrows")
  file(WRITE ${SCRATCH}/tools/make_board.cpp "${ARGN}${padding}")
  execute_process(COMMAND ${CMAKE_COMMAND} -DROOT=${SCRATCH} -P ${check}
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  string(REGEX REPLACE "[ \n]+" " " output "${output}")
  if(result EQUAL 0 OR NOT output MATCHES "${verdict}")
    message(FATAL_ERROR "${name}: expected '${verdict}', got (${result}):\n${output}")
  endif()
endfunction()
expect_tool(long_main 201 "201 lines" "")
expect_tool(package_in_a_tool 1 "a tool may not include opencv2/core.hpp" "#include <opencv2/core.hpp>")
expect_tool(route_in_a_tool 1 "a tool composes nothing, and names session, detect, calibrate"
  "#include \"procam/session/reader.hpp\"\n#include \"procam/detect/board.hpp\"\n#include \"procam/calibrate/calibrate.hpp\"\n")
