# Texts built into a program: padr_embed(VARIABLE HEADER namespace Type function folder ending) makes a source file, whose name
# VARIABLE holds then. It defines `std::span<const Type> function()`, which HEADER declares: every *.ending of the folder as
# {name without ending, text}, sorted by name. The source holds the texts and nothing of where they came from.
set(PADR_EMBED_SCRIPT "${CMAKE_CURRENT_LIST_DIR}/embed.cmake")
function(padr_embed variable header namespace type function folder ending)
  set(path "${CMAKE_CURRENT_SOURCE_DIR}/${folder}")
  file(GLOB texts RELATIVE "${path}" CONFIGURE_DEPENDS "${path}/*.${ending}")
  list(SORT texts)
  set(source "${CMAKE_CURRENT_BINARY_DIR}/${function}.cpp")
  string(REPLACE ";" "," names "${texts}")
  list(TRANSFORM texts PREPEND "${path}/")
  add_custom_command(
    OUTPUT "${source}"
    COMMAND "${CMAKE_COMMAND}" "-DOUT=${source}" "-DHEADER=${header}" "-DNAMESPACE=${namespace}" "-DTYPE=${type}"
      "-DFUNCTION=${function}" "-DTEXTS=${names}" -P "${PADR_EMBED_SCRIPT}"
    DEPENDS "${PADR_EMBED_SCRIPT}" ${texts}
    WORKING_DIRECTORY "${path}"
    VERBATIM)
  set(${variable} "${source}" PARENT_SCOPE)
endfunction()
