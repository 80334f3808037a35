#include "balance/hdf5/source.hpp"

#include "balance/base/nearest.hpp"
#include "balance/base/plain_text.hpp"
#include "balance/hdf5/checksum.hpp"
#include "balance/hdf5/server.hpp"
#include "balance/hdf5/turn.hpp"

#include <fmt/format.h>

#include <sys/socket.h>
#include <sys/time.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace balance {

namespace {

constexpr std::size_t longest_complaint = 16384;
constexpr std::size_t most_head = 1'000;  // bytes of an answer that is only sizes
constexpr std::size_t most_attribute_values = 1'000;

/// Whether it begins as HDF5 files do.
bool looks_right(const std::string& path) {
  char begin[8] = {};
  std::ifstream(path, std::ios::binary).read(begin, sizeof begin);
  return std::string(begin, sizeof begin) == "\x89HDF\r\n\x1a\n";
}

[[noreturn]] void damaged() { throw Hdf5Error("expected a whole HDF5 file, found one that is damaged"); }

/// A copy of this process may sleep for good, too.
void wait_at_most(int socket, std::uintmax_t seconds) {
  const timeval longest{static_cast<time_t>(seconds), 0};
  ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &longest, sizeof longest);
  ::setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &longest, sizeof longest);
}

}  // namespace

Hdf5Source::Hdf5Source(const std::string& file, const Hdf5Limits& limits) : limits_(limits) {
  if (checksum_of(file) == Checksum::broken)
    throw Hdf5Error("is damaged: its bytes do not have the checksum that they were written with");
  std::error_code error;
  const auto found = std::filesystem::file_size(file, error);
  const std::uintmax_t bytes = error ? 0 : found;
  values_ = values_left_ = limits.values + bytes;
  const std::uintmax_t seconds = 3 + bytes / 10'000'000;
  try {
    const Hdf5Turn turn;  // no other thread is inside the library while its state is copied
    child_.emplace([&](int line) { serve_file(file, line); },
                   ExpendableLimits{.seconds = seconds, .bytes = std::uintmax_t{256} << 20});
  } catch (const std::system_error& wrong) {
    throw Hdf5Error(fmt::format("cannot be read: there is no process left to read it in ({})", wrong.code().message()));
  }
  wait_at_most(child_->line(), 60 + 10 * seconds);
  Message answer;
  try {
    answer = Wire(child_->line()).receive(longest_complaint);
    if (answer.take_number() == 1) return;
  } catch (const WireBroken&) {
    damaged();
  }
  if (looks_right(file)) throw Hdf5Error("expected a whole HDF5 file, found one that is damaged or cut off");
  throw Hdf5Error("expected an HDF5 file, found one that cannot be opened as such");
}

/// The answer without the number that says whether it is one.
Message Hdf5Source::ask(const Message& question, std::size_t most) const {
  try {
    const Wire wire(child_->line());
    wire.send(question);
    Message answer = wire.receive(most + longest_complaint);
    if (answer.take_number() == 1) return answer;
    const std::string complaint = answer.take_text();
    throw Hdf5Error(visible(std::string_view(complaint).substr(0, longest_complaint)));
  } catch (const WireBroken&) {
    damaged();
  }
}

bool Hdf5Source::has(const std::string& path) const {
  try {
    return ask(question_about(Hdf5Question::has, path), 0).take_number() == 1;
  } catch (const WireBroken&) {
    damaged();
  }
}

/// @throws Hdf5Error if there are more than allowed
std::vector<std::size_t> Hdf5Source::checked_sizes(Message& answer, const std::string& path, std::size_t most_sizes,
                                                   std::size_t most_values) const {
  const std::uint64_t count = answer.take_number();
  if (count > most_sizes) {
    const std::string expected = most_sizes == 1 ? "one dimension" : fmt::format("at most {} dimensions", most_sizes);
    throw Hdf5Error(fmt::format("{}: expected {}, found {}", in_quotes(path), expected, count));
  }
  const std::size_t most = std::min(most_values, values_left_);
  std::vector<std::size_t> sizes;
  std::size_t total = 1;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t size = answer.take_number();
    if (size > most || total * size > most)
      throw Hdf5Error(
          most < most_values
              ? fmt::format("{}: holds more numbers than a file of this size is read for, which are {} in all",
                            in_quotes(path), values_)
              : fmt::format("{}: expected at most {} values, found more", in_quotes(path), most_values));
    total *= size;
    sizes.push_back(size);
  }
  return sizes;
}

Hdf5Source::Numbers Hdf5Source::numbers(const std::string& path, std::size_t most_sizes,
                                        std::size_t most_values) const {
  const Wire wire(child_->line());
  const auto go_on = [&wire](bool yes) {
    Message message;
    message.put(std::uint64_t{yes});
    wire.send(message);
  };
  try {
    Message answer = ask(question_about(Hdf5Question::numbers, path), most_head);
    Numbers found;
    try {
      found.sizes = checked_sizes(answer, path, most_sizes, most_values);
    } catch (const Hdf5Error&) {
      go_on(false);
      throw;
    }
    std::size_t total = 1;
    for (const std::size_t size : found.sizes) total *= size;
    values_left_ -= total;
    found.values.resize(total);
    go_on(true);
    wire.receive(found.values);
    return found;
  } catch (const WireBroken&) {
    damaged();
  }
}

std::vector<std::string> Hdf5Source::labels(const Message& question, const std::string& path) const {
  std::vector<std::string> texts;
  try {
    Message answer = ask(question, limits_.text);
    const std::uint64_t count = answer.take_number();
    if (count > limits_.labels)
      throw Hdf5Error(fmt::format("{}: expected at most {} names, found {}", in_quotes(path), limits_.labels, count));
    for (std::uint64_t i = 0; i < count; ++i) {
      texts.push_back(answer.take_text());
      if (texts.back().size() > limits_.label || visible(texts.back()) != texts.back())
        throw Hdf5Error(fmt::format("{}: expected names, found {}", in_quotes(path), in_quotes(visible(texts.back()))));
    }
  } catch (const WireBroken&) {
    damaged();
  }
  return texts;
}

std::vector<std::string> Hdf5Source::texts(const std::string& path) const {
  return labels(question_about(Hdf5Question::texts, path, "", limits_.labels), path);
}

std::vector<std::string> Hdf5Source::groups(const std::string& path) const {
  return labels(question_about(Hdf5Question::groups, path, "", limits_.labels), path);
}

std::optional<std::string> Hdf5Source::text_attribute(const std::string& path, const std::string& name) const {
  try {
    Message answer = ask(question_about(Hdf5Question::text_attribute, path, name, limits_.text), limits_.text);
    if (answer.take_number() == 0) return std::nullopt;
    std::string text = answer.take_text();
    if (!is_utf8(text) || text.find('\0') != std::string::npos)
      throw Hdf5Error(fmt::format("attribute {}: expected UTF-8, found something else", in_quotes(name)));
    return text;
  } catch (const WireBroken&) {
    damaged();
  }
}

std::optional<std::vector<double>> Hdf5Source::numbers_attribute(const std::string& path,
                                                                 const std::string& name) const {
  try {
    Message answer = ask(question_about(Hdf5Question::numbers_attribute, path, name, most_attribute_values), most_head);
    if (answer.take_number() == 0) return std::nullopt;
    const std::uint64_t count = answer.take_number();
    if (count > most_attribute_values) damaged();
    std::vector<double> values(count);
    Wire(child_->line()).receive(values);
    return values;
  } catch (const WireBroken&) {
    damaged();
  }
}

}  // namespace balance
