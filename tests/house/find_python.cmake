# Python for tests: Debian's, as for the module. What PATH has first may be a script that chooses among versions, which takes half a
# second for each of a hundred tests.
if(NOT DEFINED Python3_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python3_EXECUTABLE /usr/bin/python3)
endif()
find_package(Python3 3.9 REQUIRED COMPONENTS Interpreter)
