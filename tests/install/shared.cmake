# cmake -DPREFIX=... -DLIBDIR=... -DCOMPONENTS="core;io;..." -DTOOL=procam-studio -DOBJECTS=... -DCOMMON=... -DCXX=... -DOUT=... -P shared.cmake
#   [-DPYTHON=python3 -DPACKAGE=FOLDER -DMODULE_OBJECTS=... -DMODULE=_procam.so]
# The installed static libraries, made from hidden symbols, as shared ones: every symbol that one library takes from
# another, or a tool from any, must be exported (PROCAM_EXPORT in core/base/export.hpp). Then the tool runs on them, and the Python package is imported.
# COMPONENTS: those below before those above.
file(REMOVE_RECURSE ${OUT})
file(MAKE_DIRECTORY ${OUT})
set(ENV{PKG_CONFIG_PATH} ${PREFIX}/${LIBDIR}/pkgconfig)
foreach(component IN LISTS COMPONENTS)
  set(archive ${PREFIX}/${LIBDIR}/libprocam_${component}.a)
  if(NOT EXISTS ${archive})
    continue()  # headers alone
  endif()
  execute_process(COMMAND pkg-config --libs procam-${component} OUTPUT_VARIABLE links OUTPUT_STRIP_TRAILING_WHITESPACE
    COMMAND_ERROR_IS_FATAL ANY)
  # The prefix has static libraries alone.
  string(REGEX REPLACE "-L[^ ]*" "" links "${links}")
  string(REPLACE "-lprocam_${component} " "" links "${links} ")
  separate_arguments(links UNIX_COMMAND "${links}")
  execute_process(COMMAND ${CXX} -shared -Wl,-z,defs -Wl,--whole-archive ${archive} -Wl,--no-whole-archive -L${OUT} ${links}
      -o ${OUT}/libprocam_${component}.so
    RESULT_VARIABLE result ERROR_VARIABLE errors)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "libprocam_${component}.so cannot be linked; PROCAM_EXPORT is missing on:\n${errors}")
  endif()
endforeach()

execute_process(COMMAND pkg-config --libs procam OUTPUT_VARIABLE links OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
string(REGEX REPLACE "-L[^ ]*" "" links "${links}")
separate_arguments(links UNIX_COMMAND "${links}")
execute_process(COMMAND ${CXX} ${OBJECTS} ${COMMON} -L${OUT} -Wl,-rpath,${OUT} ${links} -o ${OUT}/${TOOL}
  RESULT_VARIABLE result ERROR_VARIABLE errors)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "${TOOL} cannot be linked with shared libraries:\n${errors}")
endif()
execute_process(COMMAND ${OUT}/${TOOL} --version COMMAND_ERROR_IS_FATAL ANY)

if(PYTHON)
  file(MAKE_DIRECTORY ${OUT}/package)
  file(COPY ${PACKAGE} DESTINATION ${OUT}/package)
  get_filename_component(name ${PACKAGE} NAME)
  execute_process(COMMAND ${CXX} -shared ${MODULE_OBJECTS} -L${OUT} -Wl,-rpath,${OUT} ${links} -o ${OUT}/package/${name}/${MODULE}
    COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND ${CMAKE_COMMAND} -E env PYTHONPATH=${OUT}/package ${PYTHON} -c "import procam"
    RESULT_VARIABLE result ERROR_VARIABLE errors)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "the Python package cannot be imported with shared libraries; PROCAM_EXPORT is missing on:\n${errors}")
  endif()
endif()
