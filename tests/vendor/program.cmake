# Both ways to use the targets, in -DLANGUAGE=C or CXX. SPDX-License-Identifier: MIT
set(CMAKE_C_STANDARD 99)
set(CMAKE_CXX_STANDARD 17)
set_source_files_properties(../main.c ../narrow.c ../own.c ../own_16.c PROPERTIES LANGUAGE ${LANGUAGE})
add_executable(with_library ../main.c ../narrow.c)
target_link_libraries(with_library conquest::static)
add_executable(with_header ../main.c ../narrow.c ../own.c ../own_16.c)
target_link_libraries(with_header conquest::conquest)
