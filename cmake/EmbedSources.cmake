# Run by `cmake -P` while building: writes a C++ file that holds source files as string literals.
#   ROOT    what the names in `#include` are relative to
#   LIST    a file with one path a line
#   OUT     the C++ file
# A file in a folder named `rtc` is included by its bare name: it stands for a header of the system.
file(STRINGS ${LIST} files)
set(text "// Written by cmake/EmbedSources.cmake.\n#include \"renderd/engine/cuda/kernel_sources.h\"\n\n")
string(APPEND text "namespace diaphane::render::cuda {\nnamespace {\n\nconstexpr KernelSourceFile kFiles[] = {\n")
file(WRITE ${OUT}.new "${text}")
foreach(file IN LISTS files)
  file(READ ${file} content)
  file(RELATIVE_PATH name ${ROOT} ${file})
  string(REGEX REPLACE "^.*/rtc/" "" name ${name})
  file(APPEND ${OUT}.new "{\"${name}\", R\"~source~(${content})~source~\"},\n")
endforeach()
file(APPEND ${OUT}.new "};\n\n}  // namespace\n\nstd::span<const KernelSourceFile> kernel_sources() { return kFiles; }\n\n")
file(APPEND ${OUT}.new "}  // namespace diaphane::render::cuda\n")
file(RENAME ${OUT}.new ${OUT})
