# In a core-only build: no compiled file may have read a header of OpenCV, Ceres or the like, wherever it lies on this
# machine. Ninja's dependency log lists what the compiler really opened.   cmake -DBUILD=<dir> -P heavy_headers.cmake
cmake_minimum_required(VERSION 3.22)
execute_process(COMMAND ${NINJA} -C ${BUILD} -t deps OUTPUT_VARIABLE deps RESULT_VARIABLE result)
string(FIND "${deps}" "Eigen/Core" eigen)
if(NOT result EQUAL 0 OR eigen EQUAL -1)
  message(FATAL_ERROR "no dependency log with Eigen in it below ${BUILD}: build first")
endif()
string(REGEX MATCHALL "[^\n]*/(opencv4|opencv2|ceres|glog|nlohmann|CLI|pugixml)[^\n]*\\.(h|hpp)" heavy "${deps}")
if(heavy)
  list(REMOVE_DUPLICATES heavy)
  list(JOIN heavy "\n" text)
  message(FATAL_ERROR "a core-only build read:\n${text}")
endif()
