# What `cmake --install` and the Debian package have. Manual pages and completions are made from the programs' --help by
# the target padr_package_files; tools/package.sh builds it and calls CPack.
include(GNUInstallDirs)

set(programs padr-peer padr-monitor padr-lab padr-report padr-capture padr-netem)
set(data "${CMAKE_INSTALL_DATADIR}/padr")
# Where Debian's Wireshark looks for plugins in Lua, whatever its version.
set(PADR_WIRESHARK_PLUGINS "lib/${CMAKE_LIBRARY_ARCHITECTURE}/wireshark/plugins" CACHE STRING
  "Where the Wireshark plugin is installed, below the prefix")

install(TARGETS ${programs} RUNTIME)
install(PROGRAMS tools/demo.sh RENAME padr-demo TYPE BIN)
install(DIRECTORY common/scenarios/paths DESTINATION "${data}" FILES_MATCHING PATTERN "*.csv")
install(DIRECTORY common/scenarios/ DESTINATION "${data}/scenarios" FILES_MATCHING PATTERN "*.textproto"
  PATTERN paths EXCLUDE)
install(DIRECTORY shell/link_traces DESTINATION "${data}" FILES_MATCHING PATTERN "*.link")
install(DIRECTORY tools/wireshark/ DESTINATION "${PADR_WIRESHARK_PLUGINS}" FILES_MATCHING PATTERN "*.lua")
install(FILES proto/wire.proto DESTINATION "${CMAKE_INSTALL_DATADIR}/wireshark/protobuf")
install(FILES tools/wireshark/colorfilters DESTINATION "${data}/wireshark")
# All that the documents link to, where the links lead; tests/package follows them.
foreach(file README.md CHANGELOG.md CONTRIBUTING.md SECURITY.md CITATION.cff LICENSE proto/WIRE.md proto/VECTORS.md proto/wire.proto
    proto/scenario.proto proto/monitor.proto tools/wireshark/README.md tools/monitor/page/PROTOCOL.md examples/own_game.cpp)
  get_filename_component(folder "${file}" DIRECTORY)
  install(FILES "${file}" DESTINATION "${CMAKE_INSTALL_DOCDIR}/${folder}" COMPONENT documents)
endforeach()
install(DIRECTORY docs DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT documents
  FILES_MATCHING PATTERN "*.md" PATTERN "*.svg" PATTERN "*.png" PATTERN "*.gif" PATTERN "*.csv")

option(PADR_PACKAGE "Manual pages, completions and the Debian package" OFF)
if(NOT PADR_PACKAGE)
  return()
endif()

find_package(Python3 REQUIRED COMPONENTS Interpreter)
find_program(HELP2MAN_PROGRAM help2man REQUIRED)
set(made "${CMAKE_BINARY_DIR}/package")
set(stamp "${made}/stamp")
set(runs "${made}/bin/padr-demo")
foreach(program ${programs})
  list(APPEND runs "$<TARGET_FILE:${program}>")
endforeach()
file(GLOB scripts CONFIGURE_DEPENDS tools/package/*)
# Alone in its folder, the demo takes itself for installed, and says so in its --help.
add_custom_command(
  OUTPUT "${stamp}"
  COMMAND "${CMAKE_COMMAND}" -E rm -rf "${made}"
  COMMAND "${CMAKE_COMMAND}" -E make_directory "${made}/bin"
  COMMAND "${CMAKE_COMMAND}" -E copy tools/demo.sh "${made}/bin/padr-demo"
  COMMAND Python3::Interpreter -B tools/package/completion.py "${made}/completions" ${runs}
  COMMAND Python3::Interpreter -B tools/package/manuals.py "${made}/man1" "${PROJECT_VERSION}" ${runs}
  COMMAND "${CMAKE_COMMAND}" -E touch "${stamp}"
  DEPENDS ${programs} ${scripts} tools/demo.sh
  WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}"
  COMMENT "Manual pages and completions"
  VERBATIM)
add_custom_target(padr_package_files DEPENDS "${stamp}")
install(DIRECTORY "${made}/man1" DESTINATION "${CMAKE_INSTALL_MANDIR}")
install(DIRECTORY "${made}/completions/" DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion/completions")

# --- the Debian package

set(debian "${CMAKE_BINARY_DIR}/debian")
file(READ LICENSE licence)
string(REGEX REPLACE "^.*\n(Permission is)" "\\1" licence "${licence}") # without its heading
string(REGEX REPLACE "\n+$" "" licence "${licence}")
string(REGEX REPLACE "\n\n" "\n.\n" licence "${licence}")
string(REGEX REPLACE "\n" "\n " licence "${licence}")
file(STRINGS LICENSE holders REGEX "^Copyright [(]c[)] ")
string(REGEX REPLACE "^Copyright [(]c[)] " "" holders "${holders}")
configure_file(cmake/debian/copyright.in "${debian}/copyright" @ONLY)
install(FILES "${debian}/copyright" TYPE DOC)
# What the programs contain of others: a library of the page, and libraries that are headers alone. Boost's licence asks
# nothing of programs.
file(GLOB others /usr/share/doc/libjs-dygraphs/copyright /usr/share/doc/libcli11-dev/copyright
  /usr/share/doc/nlohmann-json3-dev/copyright)
foreach(file IN LISTS others)
  get_filename_component(package "${file}" DIRECTORY)
  get_filename_component(package "${package}" NAME)
  install(FILES "${file}" DESTINATION "${CMAKE_INSTALL_DOCDIR}/licences" RENAME "${package}")
endforeach()
if(TARGET padr_box2d)
  install(FILES "${PADR_BOX2D_LICENCE}" DESTINATION "${CMAKE_INSTALL_DOCDIR}/licences" RENAME libbox2d-dev)
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME padr)
set(CPACK_PACKAGE_VENDOR "the PADR authors")
set(CPACK_PACKAGE_CONTACT "the PADR authors")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "gnuplot-nox | gnuplot, librsvg2-bin")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "wireshark | tshark, bash-completion")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "physics-aware dead reckoning, peer to peer")
set(CPACK_PACKAGE_DESCRIPTION "Several peers share one physical world over UDP without a server. Each
peer runs its own deterministic world, takes authority over the bodies that
its avatar touches, and tells the others only what dead reckoning cannot
guess.
.
padr-demo lets four peers play through a bad network, with a web page to look
at them and to play along. padr-lab, padr-report and padr-capture measure what
a technique costs and buys. A plugin for Wireshark is part of the package.")
include(CPack)
