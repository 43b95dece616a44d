# Installs BUILD_DIR into a prefix of its own, then builds and runs, against that alone, the project
# beside this file and the C++ example.
#   cmake -DBUILD_DIR=... -DWORK_DIR=... -DSCENES=... -DEXAMPLE=... -DFLAGS=... -P installed_project.cmake
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    list(JOIN ARGV " " command)
    message(FATAL_ERROR "exit status ${status}: ${command}")
  endif()
endfunction()

# The prefix that the package is found under is not the one it was installed to: it can be moved.
file(REMOVE_RECURSE ${WORK_DIR})
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/before)
file(RENAME ${WORK_DIR}/before ${WORK_DIR}/prefix)
run(${WORK_DIR}/prefix/bin/lucerna --version)
run(${WORK_DIR}/prefix/bin/lucernad --version)

foreach(project ${CMAKE_CURRENT_LIST_DIR}/installed_project ${EXAMPLE})
  get_filename_component(name ${project} NAME)
  run(${CMAKE_COMMAND} -G Ninja -S ${project} -B ${WORK_DIR}/${name} -DCMAKE_BUILD_TYPE=Debug
    -DCMAKE_PREFIX_PATH=${WORK_DIR}/prefix -DCMAKE_CXX_FLAGS=${FLAGS} -DSCENES=${SCENES}
    --no-warn-unused-cli)
  run(${CMAKE_COMMAND} --build ${WORK_DIR}/${name})
endforeach()
# A server of another build must not stand in for the installed one.
unset(ENV{LUCERNAD})
run(${CMAKE_CTEST_COMMAND} --test-dir ${WORK_DIR}/installed_project --output-on-failure
  --no-tests=error)
