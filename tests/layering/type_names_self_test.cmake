# Proves that type_names.cmake can fail, and that it passes what is no second definition.
#   cmake -DSCRATCH=<folder> -P type_names_self_test.cmake
cmake_minimum_required(VERSION 3.22)
set(check ${CMAKE_CURRENT_LIST_DIR}/type_names.cmake)

function(expect name second verdict)
  file(REMOVE_RECURSE ${SCRATCH})
  file(WRITE ${SCRATCH}/include/procam/io/session.hpp
    "#pragma once\nnamespace procam::io {\nstruct Session {\n  int views = 0;\n};\n}\n")
  file(WRITE ${SCRATCH}/include/procam/simulate/session.hpp
    "#pragma once\nnamespace procam::simulate {\n${second}\n}\n")
  execute_process(COMMAND ${CMAKE_COMMAND} -DROOT=${SCRATCH} -P ${check}
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  string(REGEX REPLACE "[ \n]+" " " output "${output}")
  string(FIND "${output}" "${verdict}" position)
  if(position EQUAL -1 OR (verdict MATCHES "defined once" AND NOT result EQUAL 0)
      OR (NOT verdict MATCHES "defined once" AND result EQUAL 0))
    message(FATAL_ERROR "${name}: expected '${verdict}', got (${result}):\n${output}")
  endif()
endfunction()

set(twice "Session: include/procam/simulate/session.hpp and include/procam/io/session.hpp")
expect(a_struct "struct Session {\n};" "${twice}")
expect(a_class "class Session final : public Base {\n};" "${twice}")
expect(an_exported_class "class PROCAM_EXPORT Session {\n};" "${twice}")
expect(an_enum "enum class Session { kNone };" "${twice}")
expect(an_alias "using Session = int;" "${twice}")
expect(a_template "template <typename T>\nstruct Session {\n};" "${twice}")
expect(a_template_in_one_line "template <typename T> class Session {\n};" "${twice}")
expect(another_name "struct SimulatedSession {\n};" "2 names, each defined once")
expect(a_forward_declaration "struct Session;" "1 names, each defined once")
expect(a_nested_type "class Fleet {\n  struct Session {};\n};" "2 names, each defined once")
expect(a_name_in_scope "using io::Session;" "1 names, each defined once")
file(REMOVE_RECURSE ${SCRATCH})
