#include "balance/foundation/hdf5/hdf5_read_server.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/hdf5/hdf5_handle.hpp"
#include "balance/foundation/hdf5/hdf5_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <vector>

namespace balance::hdf5 {

// Direct access to HDF5, to be run where it may crash. The only part of the reader that uses the library.

/// Stops the library from following links into other files and from loading filters, for the rest of this process.
void disable_links_and_filters();

/// An open file, or one that cannot be opened. Paths as in Hdf5Reader; every member throws Hdf5Error.
class Hdf5DirectReader {
 public:
  explicit Hdf5DirectReader(const std::string& file);
  ~Hdf5DirectReader();
  Hdf5DirectReader(const Hdf5DirectReader&) = delete;
  Hdf5DirectReader& operator=(const Hdf5DirectReader&) = delete;

  bool is_open() const { return file_ >= 0; }
  bool has(const std::string& path) const;

  /// A numeric dataset of this file.
  class Dataset {
   public:
    struct Open;
    explicit Dataset(std::unique_ptr<Open> open);
    ~Dataset();
    Dataset(Dataset&&) noexcept;
    Dataset& operator=(Dataset&&) noexcept;
    const std::vector<std::uint64_t>& sizes() const;
    /// Passes all values to `consume`, piece by piece. @return whether all could be read
    bool read(const std::function<void(std::span<const double>)>& consume) const;

   private:
    std::unique_ptr<Open> open_;
  };
  Dataset dataset(const std::string& path) const;

  std::vector<std::string> texts(const std::string& path, std::size_t max_count) const;
  std::optional<std::string> text_attribute(const std::string& path, const std::string& name,
                                            std::size_t max_bytes) const;
  std::optional<std::vector<double>> numbers_attribute(const std::string& path, const std::string& name,
                                                       std::size_t max_count) const;
  std::vector<std::string> texts_attribute(const std::string& path, const std::string& name,
                                           std::size_t max_count) const;
  std::vector<std::string> groups(const std::string& path, std::size_t max_count) const;

 private:
  std::int64_t file_ = -1;
};

namespace {

static_assert(sizeof(hid_t) == sizeof(std::int64_t));

constexpr hsize_t max_values_per_read = 1 << 17;
constexpr std::size_t max_number_bytes = 16;  // bytes; no machine has wider numbers

using hdf5::ErrorSilencer;
using hdf5::Hdf5Handle;

const char* name_in_file(const std::string& path) { return path.empty() ? "/" : path.c_str(); }

[[noreturn]] void throw_unreadable(const std::string& path) {
  throw Hdf5Error(fmt::format("{}: cannot be read", quote_for_message(path)));
}

[[noreturn]] void throw_external_storage(const std::string& path) {
  throw Hdf5Error(fmt::format("{}: is stored in another file, which is not read", quote_for_message(path)));
}

std::vector<std::uint64_t> sizes_in(hid_t space, const std::string& path) {
  const int count = H5Sget_simple_extent_ndims(space);
  if (count < 0) throw_unreadable(path);
  std::vector<hsize_t> extent(static_cast<std::size_t>(count));
  if (H5Sget_simple_extent_dims(space, extent.data(), nullptr) < 0) throw_unreadable(path);
  return {extent.begin(), extent.end()};
}

/// Number of values of a scalar or one-dimensional space.
std::size_t length_in(hid_t space, const std::string& path, std::size_t max_length) {
  const std::vector<std::uint64_t> sizes = sizes_in(space, path);
  if (sizes.size() > 1)
    throw Hdf5Error(fmt::format("{}: expected one dimension, found {}", quote_for_message(path), sizes.size()));
  const std::uint64_t length = sizes.empty() ? 1 : sizes[0];
  if (length > max_length)
    throw Hdf5Error(
        fmt::format("{}: expected at most {} values, found {}", quote_for_message(path), max_length, length));
  return length;
}

bool is_number(hid_t type) {
  const H5T_class_t kind = H5Tget_class(type);
  return (kind == H5T_FLOAT || kind == H5T_INTEGER) && H5Tget_size(type) <= max_number_bytes;
}

bool is_variable_length_string(hid_t type) { return H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) > 0; }

/// Copies texts that the library allocated, and releases them.
std::vector<std::string> take_texts(std::vector<char*>& pointers, hid_t type, hid_t space) {
  std::vector<std::string> texts;
  for (const char* pointer : pointers) texts.emplace_back(pointer == nullptr ? "" : pointer);
  H5Dvlen_reclaim(type, space, H5P_DEFAULT, static_cast<void*>(pointers.data()));
  return texts;
}

struct GroupNames {
  std::vector<std::string> names;
  std::size_t max_count = 0;
};

herr_t collect_group(hid_t owner, const char* name, const H5L_info_t* info, void* data) {
  if (info->type != H5L_TYPE_HARD) return 0;
  const Hdf5Handle object = Hdf5Handle::from_unchecked(H5Oopen(owner, name, H5P_DEFAULT), H5Oclose);
  if (!object.is_valid() || H5Iget_type(object.get()) != H5I_GROUP) return 0;
  auto& collected = *static_cast<GroupNames*>(data);
  collected.names.emplace_back(name);
  return collected.names.size() > collected.max_count ? 1 : 0;
}

/// An attribute of an object; invalid if it cannot be opened.
struct Attribute {
  Attribute(hid_t file, const std::string& path, const std::string& name)
      : attribute(Hdf5Handle::from_unchecked(
            H5Aopen_by_name(file, name_in_file(path), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose)),
        space(Hdf5Handle::from_unchecked(attribute.is_valid() ? H5Aget_space(attribute.get()) : -1, H5Sclose)),
        type(Hdf5Handle::from_unchecked(attribute.is_valid() ? H5Aget_type(attribute.get()) : -1, H5Tclose)) {}

  const Hdf5Handle attribute, space, type;
};

/// @throws Hdf5Error unless all values of the dataset are in this file
void check_storage(hid_t properties, const std::string& path) {
  const H5D_layout_t layout = H5Pget_layout(properties);
  if (layout == H5D_LAYOUT_ERROR) throw_unreadable(path);
  if (layout == H5D_VIRTUAL || H5Pget_external_count(properties) != 0) throw_external_storage(path);
}

}  // namespace

struct Hdf5DirectReader::Dataset::Open {
  explicit Open(hid_t file, const std::string& path)
      : dataset(Hdf5Handle::from_unchecked(H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose)),
        space(Hdf5Handle::from_unchecked(dataset.is_valid() ? H5Dget_space(dataset.get()) : -1, H5Sclose)),
        type(Hdf5Handle::from_unchecked(dataset.is_valid() ? H5Dget_type(dataset.get()) : -1, H5Tclose)),
        properties(Hdf5Handle::from_unchecked(dataset.is_valid() ? H5Dget_create_plist(dataset.get()) : -1, H5Pclose)) {
    if (!dataset.is_valid())
      throw Hdf5Error(fmt::format("expected a dataset {}, found something else of that name", quote_for_message(path)));
    if (!space.is_valid() || !type.is_valid() || !properties.is_valid()) throw_unreadable(path);
    check_storage(properties.get(), path);
    sizes = sizes_in(space.get(), path);
  }

  /// Number of rows per read: whole chunks, so that each is decompressed once.
  hsize_t rows_at_a_time() const {
    hsize_t row = 1;
    for (std::size_t i = 1; i < sizes.size(); ++i) row *= std::max<std::uint64_t>(sizes[i], 1);
    const hsize_t rows = std::max<hsize_t>(max_values_per_read / row, 1);
    std::vector<hsize_t> chunk(sizes.size(), 1);
    if (H5Pget_layout(properties.get()) == H5D_CHUNKED)
      H5Pget_chunk(properties.get(), static_cast<int>(chunk.size()), chunk.data());
    const hsize_t chunk_rows = std::clamp<hsize_t>(chunk[0], 1, sizes[0]);
    return std::min<hsize_t>((rows + chunk_rows - 1) / chunk_rows * chunk_rows, sizes[0]);
  }

  const ErrorSilencer silence;
  const Hdf5Handle dataset, space, type, properties;
  std::vector<std::uint64_t> sizes;
};

Hdf5DirectReader::Dataset::Dataset(std::unique_ptr<Open> open) : open_(std::move(open)) {}
Hdf5DirectReader::Dataset::~Dataset() = default;
Hdf5DirectReader::Dataset::Dataset(Dataset&&) noexcept = default;
Hdf5DirectReader::Dataset& Hdf5DirectReader::Dataset::operator=(Dataset&&) noexcept = default;

const std::vector<std::uint64_t>& Hdf5DirectReader::Dataset::sizes() const { return open_->sizes; }

bool Hdf5DirectReader::Dataset::read(const std::function<void(std::span<const double>)>& consume) const {
  const Open& self = *open_;
  if (std::find(self.sizes.begin(), self.sizes.end(), 0u) != self.sizes.end()) return true;
  if (self.sizes.empty()) {
    double value = 0;
    if (H5Dread(self.dataset.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, &value) < 0) return false;
    consume({&value, 1});
    return true;
  }
  const hsize_t step = self.rows_at_a_time();
  std::vector<hsize_t> start(self.sizes.size(), 0), count(self.sizes.begin(), self.sizes.end());
  std::vector<double> values;
  for (; start[0] < self.sizes[0]; start[0] += step) {
    count[0] = std::min<hsize_t>(step, self.sizes[0] - start[0]);
    std::size_t total = 1;
    for (const hsize_t size : count) total *= size;
    values.resize(total);
    const Hdf5Handle memory =
        Hdf5Handle::from_unchecked(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), H5Sclose);
    if (H5Sselect_hyperslab(self.space.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr) < 0 ||
        H5Dread(self.dataset.get(), H5T_NATIVE_DOUBLE, memory.get(), self.space.get(), H5P_DEFAULT, values.data()) < 0)
      return false;
    consume(values);
  }
  return true;
}

void disable_links_and_filters() {
  const ErrorSilencer silence;
  H5PLset_loading_state(0);
  H5Lunregister(H5L_TYPE_EXTERNAL);
}

Hdf5DirectReader::Hdf5DirectReader(const std::string& file) {
  const ErrorSilencer silence;
  file_ = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
}

Hdf5DirectReader::~Hdf5DirectReader() {
  const ErrorSilencer silence;
  if (file_ >= 0) H5Fclose(file_);
}

bool Hdf5DirectReader::has(const std::string& path) const {
  const ErrorSilencer silence;
  std::istringstream components(path);
  std::string component, prefix;
  while (std::getline(components, component, '/')) {
    prefix += prefix.empty() ? component : "/" + component;
    if (component.empty() || H5Lexists(file_, prefix.c_str(), H5P_DEFAULT) <= 0) return false;
    H5L_info_t link;
    if (H5Lget_info(file_, prefix.c_str(), &link, H5P_DEFAULT) < 0) throw_unreadable(prefix);
    if (link.type != H5L_TYPE_HARD && link.type != H5L_TYPE_SOFT) throw_external_storage(prefix);
  }
  return true;
}

Hdf5DirectReader::Dataset Hdf5DirectReader::dataset(const std::string& path) const {
  if (!has(path)) throw Hdf5Error(fmt::format("expected a dataset {}, found none", quote_for_message(path)));
  auto open = std::make_unique<Dataset::Open>(file_, path);
  if (!is_number(open->type.get()))
    throw Hdf5Error(fmt::format("{}: expected numbers, found another type", quote_for_message(path)));
  return Dataset(std::move(open));
}

std::vector<std::string> Hdf5DirectReader::texts(const std::string& path, std::size_t max_count) const {
  if (!has(path)) throw Hdf5Error(fmt::format("expected a dataset {}, found none", quote_for_message(path)));
  const Dataset::Open open(file_, path);
  if (!is_variable_length_string(open.type.get()))
    throw Hdf5Error(fmt::format("{}: expected strings, found something else", quote_for_message(path)));
  std::vector<char*> pointers(length_in(open.space.get(), path, max_count), nullptr);
  if (H5Dread(open.dataset.get(), open.type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, static_cast<void*>(pointers.data())) <
      0)
    throw_unreadable(path);
  return take_texts(pointers, open.type.get(), open.space.get());
}

std::optional<std::string> Hdf5DirectReader::text_attribute(const std::string& path, const std::string& name,
                                                            std::size_t max_bytes) const {
  const ErrorSilencer silence;
  if (H5Aexists_by_name(file_, name_in_file(path), name.c_str(), H5P_DEFAULT) <= 0) return std::nullopt;
  const Attribute open(file_, path, name);
  if (!open.type.is_valid() || !is_variable_length_string(open.type.get()) ||
      H5Sget_simple_extent_npoints(open.space.get()) != 1)
    throw Hdf5Error(fmt::format("attribute {}: expected a string, found something else", quote_for_message(name)));
  std::vector<char*> pointers(1, nullptr);
  if (H5Aread(open.attribute.get(), open.type.get(), static_cast<void*>(pointers.data())) < 0) throw_unreadable(name);
  std::string text = take_texts(pointers, open.type.get(), open.space.get()).front();
  if (text.size() > max_bytes)
    throw Hdf5Error(fmt::format("attribute {}: expected at most {} bytes, found {}", quote_for_message(name), max_bytes,
                                text.size()));
  return text;
}

std::optional<std::vector<double>> Hdf5DirectReader::numbers_attribute(const std::string& path, const std::string& name,
                                                                       std::size_t max_count) const {
  const ErrorSilencer silence;
  if (H5Aexists_by_name(file_, name_in_file(path), name.c_str(), H5P_DEFAULT) <= 0) return std::nullopt;
  const Attribute open(file_, path, name);
  if (!open.type.is_valid() || !is_number(open.type.get()))
    throw Hdf5Error(fmt::format("attribute {}: expected numbers, found something else", quote_for_message(name)));
  std::vector<double> values(length_in(open.space.get(), name, max_count));
  if (H5Aread(open.attribute.get(), H5T_NATIVE_DOUBLE, values.data()) < 0) throw_unreadable(name);
  return values;
}

std::vector<std::string> Hdf5DirectReader::texts_attribute(const std::string& path, const std::string& name,
                                                           std::size_t max_count) const {
  const ErrorSilencer silence;
  if (H5Aexists_by_name(file_, name_in_file(path), name.c_str(), H5P_DEFAULT) <= 0) return {};
  const Attribute open(file_, path, name);
  if (!open.type.is_valid() || !is_variable_length_string(open.type.get()))
    throw Hdf5Error(fmt::format("attribute {}: expected strings, found something else", quote_for_message(name)));
  std::vector<char*> pointers(length_in(open.space.get(), name, max_count), nullptr);
  if (H5Aread(open.attribute.get(), open.type.get(), static_cast<void*>(pointers.data())) < 0) throw_unreadable(name);
  return take_texts(pointers, open.type.get(), open.space.get());
}

std::vector<std::string> Hdf5DirectReader::groups(const std::string& path, std::size_t max_count) const {
  const ErrorSilencer silence;
  GroupNames collected{{}, max_count};
  const Hdf5Handle group = Hdf5Handle::from_unchecked(H5Gopen2(file_, name_in_file(path), H5P_DEFAULT), H5Gclose);
  if (group.is_valid()) H5Literate(group.get(), H5_INDEX_NAME, H5_ITER_INC, nullptr, collect_group, &collected);
  return std::move(collected.names);
}

namespace {

Message make_success_reply() {
  Message answer;
  answer.write(std::uint64_t{1});
  return answer;
}

/// Answers one request after the other.
class Hdf5ReadServer {
 public:
  Hdf5ReadServer(const Hdf5DirectReader& file, const MessageChannel& channel) : file_(file), channel_(channel) {}

  void answer(Message question) const {
    const auto kind = static_cast<Hdf5Request>(question.read_number());
    const std::string path = question.read_text(), name = question.read_text();
    const std::uint64_t max_count = question.read_number();
    switch (kind) {
      case Hdf5Request::has: return send_bool(file_.has(path));
      case Hdf5Request::numbers: return send_dataset(path);
      case Hdf5Request::texts: return send_list(file_.texts(path, max_count));
      case Hdf5Request::groups: return send_list(file_.groups(path, max_count));
      case Hdf5Request::text_attribute: return send_text(file_.text_attribute(path, name, max_count));
      case Hdf5Request::texts_attribute: return send_list(file_.texts_attribute(path, name, max_count));
      case Hdf5Request::numbers_attribute: return send_values(file_.numbers_attribute(path, name, max_count));
    }
  }

 private:
  void send_bool(bool value) const {
    Message answer = make_success_reply();
    answer.write(std::uint64_t{value});
    channel_.send(answer);
  }

  void send_dataset(const std::string& path) const {
    const Hdf5DirectReader::Dataset dataset = file_.dataset(path);
    Message answer = make_success_reply();
    answer.write(std::uint64_t{dataset.sizes().size()});
    for (const std::uint64_t size : dataset.sizes()) answer.write(size);
    channel_.send(answer);
    if (channel_.receive(sizeof(std::uint64_t)).read_number() != 1) return;
    // An error cannot be reported between two values.
    if (!dataset.read([this](std::span<const double> values) { channel_.send(values); }))
      throw ChannelError("the values cannot be read");
  }

  void send_list(const std::vector<std::string>& texts) const {
    Message answer = make_success_reply();
    answer.write(std::uint64_t{texts.size()});
    for (const std::string& text : texts) answer.write(text);
    channel_.send(answer);
  }

  void send_text(const std::optional<std::string>& text) const {
    Message answer = make_success_reply();
    answer.write(std::uint64_t{text.has_value()});
    if (text) answer.write(*text);
    channel_.send(answer);
  }

  void send_values(const std::optional<std::vector<double>>& values) const {
    Message answer = make_success_reply();
    answer.write(std::uint64_t{values.has_value()});
    if (values) answer.write(std::uint64_t{values->size()});
    channel_.send(answer);
    if (values) channel_.send(*values);
  }

  const Hdf5DirectReader& file_;
  const MessageChannel& channel_;
};

void send_error(const MessageChannel& channel, const std::string& reason) {
  Message answer;
  answer.write(std::uint64_t{0});
  answer.write(reason);
  channel.send(answer);
}

}  // namespace

Message make_read_request(Hdf5Request question, const std::string& path, const std::string& name,
                          std::uint64_t max_count) {
  Message message;
  message.write(static_cast<std::uint64_t>(question));
  message.write(path);
  message.write(name);
  message.write(max_count);
  return message;
}

namespace {

void answer_questions(const std::string& file, const MessageChannel& channel, void (*on_open)()) {
  constexpr std::size_t max_request_bytes = 1 << 20;
  try {
    const Hdf5DirectReader reader(file);
    if (on_open != nullptr) on_open();
    Message opened;
    opened.write(std::uint64_t{reader.is_open()});
    channel.send(opened);
    const Hdf5ReadServer server(reader, channel);
    while (reader.is_open()) {
      Message question = channel.receive(max_request_bytes);
      try {
        server.answer(std::move(question));
      } catch (const Hdf5Error& error) {
        send_error(channel, error.what());
      }
    }
  } catch (const ChannelError&) {  // the client is gone
  }
}

}  // namespace

void serve_requests(const std::string& file, const MessageChannel& channel) {
  answer_questions(file, channel, nullptr);
}

void run_read_server(const std::string& file, int socket) {
  disable_links_and_filters();
  answer_questions(file, MessageChannel(socket), forbid_opening_files);
}

}  // namespace balance::hdf5
