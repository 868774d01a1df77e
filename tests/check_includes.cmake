# Holds the arrows of the house: format includes nothing of the other two; compiler and solver include format, never
# each other; OpenMesh, Embree and JSON stay out of headers and in their own folder.
# Run: cmake -DROOT=<repository> -P check_includes.cmake
set(faults 0)

function(forbid folder pattern reason)
  file(GLOB_RECURSE files ${ROOT}/${folder}/*.h ${ROOT}/${folder}/*.cpp)
  foreach(file IN LISTS files)
    file(STRINGS ${file} hits REGEX "#include [<\"](${pattern})")
    foreach(hit IN LISTS hits)
      message(SEND_ERROR "${file}: ${hit}: ${reason}")
    endforeach()
  endforeach()
endfunction()

forbid(format "compiler/|solver/" "format depends on neither program")
forbid(compiler "solver/" "the compiler does not see the solver")
forbid(solver "compiler/" "the solver does not see the compiler")
forbid(solver "OpenMesh" "only the compiler sees OpenMesh")
foreach(folder compiler solver)
  forbid(${folder} "embree" "only format/rays sees Embree")
endforeach()

file(GLOB_RECURSE headers ${ROOT}/format/*.h ${ROOT}/compiler/*.h ${ROOT}/solver/*.h)
list(FILTER headers EXCLUDE REGEX "/format/tool/")
foreach(header IN LISTS headers)
  file(STRINGS ${header} hits REGEX "#include <(embree|OpenMesh|nlohmann|valijson|tiny_)")
  foreach(hit IN LISTS hits)
    message(SEND_ERROR "${header}: ${hit}: headers show only our own types")
  endforeach()
endforeach()
