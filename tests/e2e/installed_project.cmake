# Installs BUILD_DIR into a prefix.  Then builds and runs the project beside this file and the C++ example, with that
# prefix only.  The example is also built by pkg-config.
#   cmake -DBUILD_DIR=... -DWORK_DIR=... -DSCENES=... -DEXAMPLE=... -DFLAGS=... -DCXX=... -DCCACHE=... -DTESTING=... -P installed_project.cmake
# CCACHE is ccache, or false if it is not installed.  TESTING is the archive of lucerna::testing, which `make demo` does not build.
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    list(JOIN ARGV " " command)
    message(FATAL_ERROR "exit status ${status}: ${command}")
  endif()
endfunction()

if(CCACHE)
  set(ENV{CMAKE_CXX_COMPILER_LAUNCHER} ${CCACHE})
  set(ENV{CCACHE_BASEDIR} ${WORK_DIR})
  set(ENV{CCACHE_NOHASHDIR} 1)
endif()

# The test needs a tree like that of `make demo`.  So the library is moved away, and back before anything can fail.
file(REMOVE_RECURSE ${WORK_DIR})
file(RENAME ${TESTING} ${TESTING}.away)
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/small RESULT_VARIABLE status)
file(RENAME ${TESTING}.away ${TESTING})
if(NOT status EQUAL 0)
  message(FATAL_ERROR "exit status ${status}: installation without ${TESTING}")
endif()
run(${CMAKE_COMMAND} -G Ninja -S ${EXAMPLE} -B ${WORK_DIR}/small_example -DCMAKE_PREFIX_PATH=${WORK_DIR}/small
  -DCMAKE_CXX_FLAGS=${FLAGS})

# The package is moved after its installation: it must not contain its prefix.
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/before)
file(RENAME ${WORK_DIR}/before ${WORK_DIR}/prefix)
run(${WORK_DIR}/prefix/bin/lucerna --version)
run(${WORK_DIR}/prefix/bin/lucernad --version)
run(${WORK_DIR}/prefix/bin/lucerna tradeoff --version)

# By pkg-config alone.  Without arguments, the example ends with status 2.
file(GLOB pkgconfig ${WORK_DIR}/prefix/lib*/pkgconfig ${WORK_DIR}/prefix/lib/*/pkgconfig)
set(ENV{PKG_CONFIG_PATH} ${pkgconfig})
run(sh -c "\"$1\" $4 \"$2\" -o \"$3\" $(pkg-config --cflags --libs lucerna)" sh
  ${CXX} ${EXAMPLE}/ask.cpp ${WORK_DIR}/ask ${FLAGS})
execute_process(COMMAND ${WORK_DIR}/ask RESULT_VARIABLE status)
if(NOT status EQUAL 2)
  message(FATAL_ERROR "exit status ${status} of the example, expected 2")
endif()

foreach(project ${CMAKE_CURRENT_LIST_DIR}/installed_project ${CMAKE_CURRENT_LIST_DIR}/plain_project ${EXAMPLE})
  get_filename_component(name ${project} NAME)
  run(${CMAKE_COMMAND} -G Ninja -S ${project} -B ${WORK_DIR}/${name} -DCMAKE_BUILD_TYPE=Debug
    -DCMAKE_PREFIX_PATH=${WORK_DIR}/prefix -DCMAKE_CXX_FLAGS=${FLAGS} -DSCENES=${SCENES}
    --no-warn-unused-cli)
  run(${CMAKE_COMMAND} --build ${WORK_DIR}/${name})
endforeach()
# The test must start the installed server and not one that the environment names.
unset(ENV{LUCERNAD})
foreach(name installed_project plain_project)
  run(${CMAKE_CTEST_COMMAND} --test-dir ${WORK_DIR}/${name} --output-on-failure --no-tests=error)
endforeach()
