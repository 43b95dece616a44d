# Installs BUILD_DIR into a prefix of its own.  Builds against that prefix alone, and runs, the two projects
# beside this file and the C++ example.
#   cmake -DBUILD_DIR=... -DWORK_DIR=... -DSCENES=... -DEXAMPLE=... -DFLAGS=... -P installed_project.cmake
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    list(JOIN ARGV " " command)
    message(FATAL_ERROR "exit status ${status}: ${command}")
  endif()
endfunction()

# The prefix moves after the installation, so the package must not hold its old path.
file(REMOVE_RECURSE ${WORK_DIR})
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/before)
file(RENAME ${WORK_DIR}/before ${WORK_DIR}/prefix)
run(${WORK_DIR}/prefix/bin/lucerna --version)
run(${WORK_DIR}/prefix/bin/lucernad --version)

foreach(project ${CMAKE_CURRENT_LIST_DIR}/installed_project ${CMAKE_CURRENT_LIST_DIR}/plain_project ${EXAMPLE})
  get_filename_component(name ${project} NAME)
  run(${CMAKE_COMMAND} -G Ninja -S ${project} -B ${WORK_DIR}/${name} -DCMAKE_BUILD_TYPE=Debug
    -DCMAKE_PREFIX_PATH=${WORK_DIR}/prefix -DCMAKE_CXX_FLAGS=${FLAGS} -DSCENES=${SCENES}
    --no-warn-unused-cli)
  run(${CMAKE_COMMAND} --build ${WORK_DIR}/${name})
endforeach()
# A server of another build must not stand in for the installed one.
unset(ENV{LUCERNAD})
foreach(name installed_project plain_project)
  run(${CMAKE_CTEST_COMMAND} --test-dir ${WORK_DIR}/${name} --output-on-failure --no-tests=error)
endforeach()
