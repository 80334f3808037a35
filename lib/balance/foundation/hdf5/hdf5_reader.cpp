#include "balance/foundation/hdf5/hdf5_reader.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/foundation/hdf5/file_checksum.hpp"
#include "balance/foundation/hdf5/hdf5_read_server.hpp"

#include <fmt/format.h>

#include <sys/socket.h>
#include <sys/time.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace balance::hdf5 {

namespace {

constexpr std::size_t max_error_bytes = 16384;
constexpr std::size_t max_header_bytes = 1'000;  // of an answer that contains only sizes
constexpr std::size_t max_attribute_values = 1'000;

/// Whether the file starts with the signature of HDF5.
bool has_hdf5_signature(const std::string& path) {
  char begin[8] = {};
  std::ifstream(path, std::ios::binary).read(begin, sizeof begin);
  return std::string(begin, sizeof begin) == "\x89HDF\r\n\x1a\n";
}

[[noreturn]] void throw_damaged() { throw Hdf5Error("expected an intact HDF5 file, found one that is damaged"); }

/// The child may also sleep forever, which no CPU limit ends.
void set_socket_timeout(int socket, std::uintmax_t seconds) {
  const timeval longest{static_cast<time_t>(seconds), 0};
  ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &longest, sizeof longest);
  ::setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &longest, sizeof longest);
}

}  // namespace

Hdf5Reader::Hdf5Reader(const std::string& file, const Hdf5ReadLimits& limits) : limits_(limits) {
  if (verify_checksum(file) == ChecksumStatus::mismatch)
    throw Hdf5Error("is damaged: its contents do not match its checksum");
  std::error_code error;
  const auto file_bytes = std::filesystem::file_size(file, error);
  const std::uintmax_t bytes = error ? 0 : file_bytes;
  value_limit_ = remaining_values_ = limits.max_values + bytes;
  const std::uintmax_t seconds = 3 + bytes / 10'000'000;
  try {
    child_.emplace([&](int socket) { run_read_server(file, socket); },
                   SandboxLimits{.cpu_seconds = seconds, .memory_bytes = std::uintmax_t{256} << 20},
                   SandboxAccess::socket_only);
  } catch (const std::system_error& failure) {
    throw Hdf5Error(
        fmt::format("cannot be read: no process could be started to read it ({})", failure.code().message()));
  }
  set_socket_timeout(child_->socket(), 60 + 10 * seconds);
  Message answer;
  try {
    answer = MessageChannel(child_->socket()).receive(max_error_bytes);
    if (answer.read_number() == 1) return;
  } catch (const ChannelError&) {
    throw_damaged();
  }
  if (has_hdf5_signature(file)) throw Hdf5Error("expected an intact HDF5 file, found one that is damaged or truncated");
  throw Hdf5Error("expected an HDF5 file, found one that cannot be opened as such");
}

/// Returns the answer without its leading status number.
Message Hdf5Reader::request(const Message& question, std::size_t max_bytes) const {
  try {
    const MessageChannel channel(child_->socket());
    channel.send(question);
    Message answer = channel.receive(max_bytes + max_error_bytes);
    if (answer.read_number() == 1) return answer;
    const std::string reason = answer.read_text();
    throw Hdf5Error(escape_for_terminal(std::string_view(reason).substr(0, max_error_bytes)));
  } catch (const ChannelError&) {
    throw_damaged();
  }
}

bool Hdf5Reader::has(const std::string& path) const {
  try {
    return request(make_read_request(Hdf5Request::has, path), 0).read_number() == 1;
  } catch (const ChannelError&) {
    throw_damaged();
  }
}

/// @throws Hdf5Error if there are more dimensions or values than allowed
std::vector<std::size_t> Hdf5Reader::checked_sizes(Message& answer, const std::string& path, std::size_t max_dimensions,
                                                   std::size_t max_values) const {
  const std::uint64_t count = answer.read_number();
  if (count > max_dimensions) {
    const std::string expected =
        max_dimensions == 1 ? "one dimension" : fmt::format("at most {} dimensions", max_dimensions);
    throw Hdf5Error(fmt::format("{}: expected {}, found {}", quote_for_message(path), expected, count));
  }
  const std::size_t allowed_values = std::min(max_values, remaining_values_);
  std::vector<std::size_t> sizes;
  std::size_t total = 1;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t size = answer.read_number();
    if (size > allowed_values || total * size > allowed_values)
      throw Hdf5Error(
          allowed_values < max_values
              ? fmt::format("{}: holds too many numbers for a file of this size; the limit is {} in all",
                            quote_for_message(path), value_limit_)
              : fmt::format("{}: expected at most {} values, found more", quote_for_message(path), max_values));
    total *= size;
    sizes.push_back(size);
  }
  return sizes;
}

Hdf5Reader::Dataset Hdf5Reader::numbers(const std::string& path, std::size_t max_dimensions,
                                        std::size_t max_values) const {
  const MessageChannel channel(child_->socket());
  const auto send_confirmation = [&channel](bool accepted) {
    Message message;
    message.write(std::uint64_t{accepted});
    channel.send(message);
  };
  try {
    Message answer = request(make_read_request(Hdf5Request::numbers, path), max_header_bytes);
    Dataset dataset;
    try {
      dataset.sizes = checked_sizes(answer, path, max_dimensions, max_values);
    } catch (const Hdf5Error&) {
      send_confirmation(false);
      throw;
    }
    std::size_t total = 1;
    for (const std::size_t size : dataset.sizes) total *= size;
    remaining_values_ -= total;
    dataset.values.resize(total);
    send_confirmation(true);
    channel.receive(dataset.values);
    return dataset;
  } catch (const ChannelError&) {
    throw_damaged();
  }
}

std::vector<std::string> Hdf5Reader::labels(const Message& question, const std::string& path) const {
  std::vector<std::string> texts;
  try {
    Message answer = request(question, limits_.max_attribute_bytes);
    const std::uint64_t count = answer.read_number();
    if (count > limits_.max_labels)
      throw Hdf5Error(
          fmt::format("{}: expected at most {} names, found {}", quote_for_message(path), limits_.max_labels, count));
    for (std::uint64_t i = 0; i < count; ++i) {
      texts.push_back(answer.read_text());
      if (texts.back().size() > limits_.max_label_bytes || escape_for_terminal(texts.back()) != texts.back())
        throw Hdf5Error(fmt::format("{}: expected names, found {}", quote_for_message(path),
                                    quote_for_message(escape_for_terminal(texts.back()))));
    }
  } catch (const ChannelError&) {
    throw_damaged();
  }
  return texts;
}

std::vector<std::string> Hdf5Reader::texts(const std::string& path) const {
  return labels(make_read_request(Hdf5Request::texts, path, "", limits_.max_labels), path);
}

std::vector<std::string> Hdf5Reader::texts_attribute(const std::string& path, const std::string& name) const {
  return labels(make_read_request(Hdf5Request::texts_attribute, path, name, limits_.max_labels), name);
}

std::vector<std::string> Hdf5Reader::groups(const std::string& path) const {
  return labels(make_read_request(Hdf5Request::groups, path, "", limits_.max_labels), path);
}

std::optional<std::string> Hdf5Reader::text_attribute(const std::string& path, const std::string& name) const {
  try {
    Message answer = request(make_read_request(Hdf5Request::text_attribute, path, name, limits_.max_attribute_bytes),
                             limits_.max_attribute_bytes);
    if (answer.read_number() == 0) return std::nullopt;
    std::string text = answer.read_text();
    if (!is_utf8(text) || text.find('\0') != std::string::npos)
      throw Hdf5Error(fmt::format("attribute {}: expected UTF-8, found something else", quote_for_message(name)));
    return text;
  } catch (const ChannelError&) {
    throw_damaged();
  }
}

std::optional<std::vector<double>> Hdf5Reader::numbers_attribute(const std::string& path,
                                                                 const std::string& name) const {
  try {
    Message answer =
        request(make_read_request(Hdf5Request::numbers_attribute, path, name, max_attribute_values), max_header_bytes);
    if (answer.read_number() == 0) return std::nullopt;
    const std::uint64_t count = answer.read_number();
    if (count > max_attribute_values) throw_damaged();
    std::vector<double> values(count);
    MessageChannel(child_->socket()).receive(values);
    return values;
  } catch (const ChannelError&) {
    throw_damaged();
  }
}

}  // namespace balance::hdf5
