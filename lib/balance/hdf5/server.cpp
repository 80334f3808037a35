#include "balance/hdf5/server.hpp"

#include "balance/hdf5/library.hpp"

#include <vector>

namespace balance {

namespace {

Message make_success_reply() {
  Message answer;
  answer.write(std::uint64_t{1});
  return answer;
}

/// Answers one question after the other.
class Hdf5ReadServer {
 public:
  Hdf5ReadServer(const Hdf5DirectReader& file, const MessageChannel& wire) : file_(file), wire_(wire) {}

  void answer(Message question) const {
    const auto kind = static_cast<Hdf5Request>(question.read_number());
    const std::string path = question.read_text(), name = question.read_text();
    const std::uint64_t most = question.read_number();
    switch (kind) {
      case Hdf5Request::has: return say_whether(file_.has(path));
      case Hdf5Request::numbers: return send_dataset(path);
      case Hdf5Request::texts: return say_list(file_.texts(path, most));
      case Hdf5Request::groups: return say_list(file_.groups(path, most));
      case Hdf5Request::text_attribute: return say_text(file_.text_attribute(path, name, most));
      case Hdf5Request::numbers_attribute: return say_values(file_.numbers_attribute(path, name, most));
    }
  }

 private:
  void say_whether(bool so) const {
    Message answer = make_success_reply();
    answer.write(std::uint64_t{so});
    wire_.send(answer);
  }

  void send_dataset(const std::string& path) const {
    const Hdf5DirectReader::Dataset dataset = file_.dataset(path);
    Message answer = make_success_reply();
    answer.write(std::uint64_t{dataset.sizes().size()});
    for (const std::uint64_t size : dataset.sizes()) answer.write(size);
    wire_.send(answer);
    if (wire_.receive(sizeof(std::uint64_t)).read_number() != 1) return;
    // There is no way to complain between two values.
    if (!dataset.read([this](std::span<const double> values) { wire_.send(values); }))
      throw ChannelError("the values cannot be read");
  }

  void say_list(const std::vector<std::string>& texts) const {
    Message answer = make_success_reply();
    answer.write(std::uint64_t{texts.size()});
    for (const std::string& text : texts) answer.write(text);
    wire_.send(answer);
  }

  void say_text(const std::optional<std::string>& text) const {
    Message answer = make_success_reply();
    answer.write(std::uint64_t{text.has_value()});
    if (text) answer.write(*text);
    wire_.send(answer);
  }

  void say_values(const std::optional<std::vector<double>>& values) const {
    Message answer = make_success_reply();
    answer.write(std::uint64_t{values.has_value()});
    if (values) answer.write(std::uint64_t{values->size()});
    wire_.send(answer);
    if (values) wire_.send(*values);
  }

  const Hdf5DirectReader& file_;
  const MessageChannel& wire_;
};

void send_error(const MessageChannel& wire, const std::string& reason) {
  Message answer;
  answer.write(std::uint64_t{0});
  answer.write(reason);
  wire.send(answer);
}

}  // namespace

Message make_read_request(Hdf5Request question, const std::string& path, const std::string& name, std::uint64_t most) {
  Message message;
  message.write(static_cast<std::uint64_t>(question));
  message.write(path);
  message.write(name);
  message.write(most);
  return message;
}

namespace {

void answer_questions(const std::string& file, const MessageChannel& wire, void (*once_open)()) {
  constexpr std::size_t max_request_bytes = 1 << 20;
  try {
    const Hdf5DirectReader library(file);
    if (once_open != nullptr) once_open();
    Message opened;
    opened.write(std::uint64_t{library.is_open()});
    wire.send(opened);
    const Hdf5ReadServer server(library, wire);
    while (library.is_open()) {
      Message question = wire.receive(max_request_bytes);
      try {
        server.answer(std::move(question));
      } catch (const Hdf5Error& error) {
        send_error(wire, error.what());
      }
    }
  } catch (const ChannelError&) {  // nobody asks any more
  }
}

}  // namespace

void serve_requests(const std::string& file, const MessageChannel& wire) { answer_questions(file, wire, nullptr); }

void run_read_server(const std::string& file, int socket) {
  disable_links_and_filters();
  answer_questions(file, MessageChannel(socket), forbid_opening_files);
}

}  // namespace balance
