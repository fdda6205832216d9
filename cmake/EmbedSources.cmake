# Run by `cmake -P` during the build. Writes a C++ file with source files as string literals.
#   ROOT    the folder to which the names in `#include` are relative
#   LIST    a file with one path per line
#   OUT     the C++ file
# A file in a folder named `rtc` replaces a system header and is included by its bare name.
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
