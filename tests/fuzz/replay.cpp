// Runs a target over files, as libFuzzer would, without it: `test_fuzz TARGET LIMIT FILE…`. A file may take LIMIT seconds.

#include "targets.hpp"

#include <sys/resource.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

namespace {

namespace fs = std::filesystem;

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  if (!fs::exists(folder)) return files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file()) files.push_back(entry.path());
  return files;
}

double seconds_of(balance::fuzz::Target target, const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  const std::clock_t begin = std::clock();  // of the processor: the machine may be busy
  target(bytes);
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

long peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss / 1024;
}

}  // namespace

int main(int count, char** arguments) {
  const balance::fuzz::Target target = count > 3 ? balance::fuzz::find_target(arguments[1]) : nullptr;
  if (target == nullptr) {
    std::fprintf(stderr, "usage: test_fuzz TARGET SECONDS FOLDER...\n");
    return 2;
  }
  const double limit = std::strtod(arguments[2], nullptr);
  int files = 0, slow = 0;
  for (int i = 3; i < count; ++i) {
    for (const fs::path& path : files_in(arguments[i])) {
      std::printf("%s\n", path.c_str());
      std::fflush(stdout);  // the last one shows which file it was
      ++files;
      const double seconds = seconds_of(target, path);
      if (seconds > limit) std::printf("took %.1f s\n", seconds), ++slow;
    }
  }
  constexpr long max_memory = 512;  // MiB, as in the campaigns
  const long memory = peak_memory();
  std::printf("%d files, %d slow, %ld MiB\n", files, slow, memory);
  return files == 0 || slow > 0 || memory > max_memory ? 1 : 0;
}
