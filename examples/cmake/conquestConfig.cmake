# find_package(conquest): the targets of an installed conquest, see CMakeLists.txt. It finds its files by its own place,
# lib/cmake/conquest, so that an installation may be moved. SPDX-License-Identifier: MIT
find_path(conquest_INCLUDE_DIR conquest.h NO_CACHE NO_DEFAULT_PATH REQUIRED
    PATHS ${CMAKE_CURRENT_LIST_DIR}/../../../include ${CMAKE_CURRENT_LIST_DIR}/../../../../include)
find_library(conquest_LIBRARY conquest NO_CACHE NO_DEFAULT_PATH REQUIRED PATHS ${CMAKE_CURRENT_LIST_DIR}/../..)

if(NOT TARGET conquest::conquest)
    add_library(conquest::conquest INTERFACE IMPORTED)
    target_include_directories(conquest::conquest INTERFACE ${conquest_INCLUDE_DIR})
    add_library(conquest::static STATIC IMPORTED)
    set_target_properties(conquest::static PROPERTIES IMPORTED_LOCATION ${conquest_LIBRARY})
    target_link_libraries(conquest::static INTERFACE conquest::conquest)
endif()
