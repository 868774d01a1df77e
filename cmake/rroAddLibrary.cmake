# rro_add_library(NAME MESHES mesh... [OPTIONS option...] [OUT folder])
# rro_add_library(NAME LIBRARY library.json [OPTIONS option...] [OUT folder])
#
# A target NAME, built by default, that compiles an object library into FOLDER (default: NAME in the current binary folder):
# one archive per mesh, named by its stem, as `rro-compile build` does with OPTIONS; or the objects of LIBRARY, as
# `rro-compile library` does. Paths are relative to the current source folder, OUT to the current binary folder.
#
# What a mesh refers to (MTL, textures, .bin) is known from the depfiles of the compiler: an archive is made again when any
# of it changes, when the options do, and when the compiler is another. The archives, as absolute paths, are in the variable
# NAME_ARCHIVES and in the target's property RRO_ARCHIVES.

# In `variable`, the names of the objects of a library; the file is read again whenever it changes.
function(_rro_objects_of library variable)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${library}")
  file(READ "${library}" text)
  string(JSON count ERROR_VARIABLE fault LENGTH "${text}" objects)
  if(fault)
    message(FATAL_ERROR "${library}: ${fault}")
  endif()
  set(names)
  if(count GREATER 0)
    math(EXPR last "${count} - 1")
    foreach(i RANGE ${last})
      string(JSON name ERROR_VARIABLE fault GET "${text}" objects ${i} name)
      if(fault)
        message(FATAL_ERROR "${library}: /objects/${i}: ${fault}")
      endif()
      list(APPEND names "${name}")
    endforeach()
  endif()
  set(${variable} "${names}" PARENT_SCOPE)
endfunction()

# In `variable`, a depfile for these archives alone: ninja stops at one of an earlier list, with archives that are no longer
# made.
function(_rro_depfile_of archives variable)
  string(SHA256 id "${archives}")
  set(folder "${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/rro")
  file(MAKE_DIRECTORY "${folder}")
  set(${variable} "${folder}/${id}.d" PARENT_SCOPE)
endfunction()

function(rro_add_library name)
  cmake_parse_arguments(PARSE_ARGV 1 ARG "" "LIBRARY;OUT" "MESHES;OPTIONS")
  if(ARG_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "rro_add_library(${name}): unknown arguments: ${ARG_UNPARSED_ARGUMENTS}")
  endif()
  if((ARG_MESHES AND ARG_LIBRARY) OR NOT (ARG_MESHES OR ARG_LIBRARY))
    message(FATAL_ERROR "rro_add_library(${name}): expected either MESHES or LIBRARY")
  endif()
  if(NOT ARG_OUT)
    set(ARG_OUT "${name}")
  endif()
  get_filename_component(out "${ARG_OUT}" ABSOLUTE BASE_DIR "${CMAKE_CURRENT_BINARY_DIR}")
  file(MAKE_DIRECTORY "${out}")
  set(compiler "$<TARGET_FILE:rro::rro-compile>")

  set(archives)
  if(ARG_LIBRARY)
    get_filename_component(library "${ARG_LIBRARY}" ABSOLUTE)
    _rro_objects_of("${library}" objects)
    foreach(object IN LISTS objects)
      list(APPEND archives "${out}/${object}.rro")
    endforeach()
    if(archives)
      _rro_depfile_of("${archives}" depfile)
      add_custom_command(
        OUTPUT ${archives}
        COMMAND "${compiler}" library "${library}" --out "${out}" --depfile "${depfile}" ${ARG_OPTIONS}
        DEPENDS "${library}" "${compiler}"
        DEPFILE "${depfile}"
        COMMENT "Compiling what has changed of ${ARG_LIBRARY}"
        VERBATIM)
    endif()
  endif()
  foreach(mesh IN LISTS ARG_MESHES)
    get_filename_component(source "${mesh}" ABSOLUTE)
    get_filename_component(stem "${mesh}" NAME_WLE)
    set(archive "${out}/${stem}.rro")
    if(archive IN_LIST archives)
      message(FATAL_ERROR "rro_add_library(${name}): two meshes would become ${archive}")
    endif()
    list(APPEND archives "${archive}")
    _rro_depfile_of("${archive}" depfile)
    add_custom_command(
      OUTPUT "${archive}"
      COMMAND "${compiler}" build "${source}" --out "${archive}" --depfile "${depfile}" ${ARG_OPTIONS}
      DEPENDS "${source}" "${compiler}"
      DEPFILE "${depfile}"
      COMMENT "Compiling ${mesh}"
      VERBATIM)
  endforeach()

  add_custom_target(${name} ALL DEPENDS ${archives})
  set_target_properties(${name} PROPERTIES RRO_ARCHIVES "${archives}")
  set(${name}_ARCHIVES "${archives}" PARENT_SCOPE)
endfunction()
