# Takes the programs out of a page: a block ```cpp whose first line is "// name.cpp" or, if it needs that part of the library,
# "// name.cpp, synthesis" becomes folder/<part>/name.cpp, the block ```text behind it folder/<part>/name.txt, what it prints.
# usage: awk -v folder=F -f page_programs.awk page.md
/^```cpp$/ {
  getline line
  if (line !~ /^\/\/ [a-z_]+\.cpp(, [a-z]+)?$/) { print "a program without a name: " line > "/dev/stderr"; exit 1 }
  part = line ~ /,/ ? line : "core"
  sub(/.*, /, "", part)
  name = line
  sub(/^\/\/ /, "", name)
  sub(/\.cpp.*/, "", name)
  file = folder "/" part "/" name ".cpp"
  print line > file
  next
}
/^```text$/ { file = folder "/" part "/" name ".txt"; next }
/^```/ { if (file) close(file); file = ""; next }
file { print > file }
