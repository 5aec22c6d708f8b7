# Proves that words.cmake can fail: words in comments, literals and documents, and what it lets pass.
#   cmake -DSCRATCH=<folder> -P words_self_test.cmake
cmake_minimum_required(VERSION 3.22)
set(check ${CMAKE_CURRENT_LIST_DIR}/words.cmake)

function(expect name file text verdict)
  file(REMOVE_RECURSE ${SCRATCH})
  file(WRITE ${SCRATCH}/tests/layering/words.txt
    "# a comment\nforetell* | predict |\nfor want of | without |\ngate | quality check | ^src/detect/\nkMost* | kMax... |\n")
  file(WRITE ${SCRATCH}/${file} "${text}\n")
  execute_process(COMMAND ${CMAKE_COMMAND} -DROOT=${SCRATCH} -P ${check}
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  string(REGEX REPLACE "[ \n]+" " " output "${output}")
  string(FIND "${output}" "${verdict}" position)
  if(position EQUAL -1 OR (verdict MATCHES "1 files without" AND NOT result EQUAL 0)
      OR (NOT verdict MATCHES "1 files without" AND result EQUAL 0))
    message(FATAL_ERROR "${name}: expected '${verdict}', got (${result}):\n${output}")
  endif()
endfunction()

expect(a_comment src/track/a.cpp "/// It foretells the pose." "'foretells', instead: predict")
expect(its_first_letter docs/a.md "Foretell it." "'Foretell', instead: predict")
expect(several_words tools/a.cpp "say(\"black for want of a pose\");" "'for want of', instead: without")
expect(an_identifier include/procam/core/a.hpp "constexpr int kMostSteps = 3;" "'kMostSteps', instead: kMax...")
expect(elsewhere src/calibrate/a.cpp "// the gate" "'gate', instead: quality check")
expect(where_it_may_stay src/detect/a.cpp "// the gate" "1 files without")
expect(part_of_a_word src/calibrate/a.cpp "// aggregates, navigate, gated" "1 files without")
expect(another_word src/calibrate/a.cpp "// predicts without a pose; kMaxSteps" "1 files without")
file(REMOVE_RECURSE ${SCRATCH})
