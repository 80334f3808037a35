#include "balance/hdf5/server.hpp"

#include "balance/hdf5/library.hpp"

#include <vector>

namespace balance {

namespace {

Message good() {
  Message answer;
  answer.put(std::uint64_t{1});
  return answer;
}

/// Answers one question after the other.
class Hdf5Server {
 public:
  Hdf5Server(const Hdf5Library& file, const Wire& wire) : file_(file), wire_(wire) {}

  void answer(Message question) const {
    const auto kind = static_cast<Hdf5Question>(question.take_number());
    const std::string path = question.take_text(), name = question.take_text();
    const std::uint64_t most = question.take_number();
    switch (kind) {
      case Hdf5Question::has: return say_whether(file_.has(path));
      case Hdf5Question::numbers: return say_numbers(path);
      case Hdf5Question::texts: return say_list(file_.texts(path, most));
      case Hdf5Question::groups: return say_list(file_.groups(path, most));
      case Hdf5Question::text_attribute: return say_text(file_.text_attribute(path, name, most));
      case Hdf5Question::numbers_attribute: return say_values(file_.numbers_attribute(path, name, most));
    }
  }

 private:
  void say_whether(bool so) const {
    Message answer = good();
    answer.put(std::uint64_t{so});
    wire_.send(answer);
  }

  void say_numbers(const std::string& path) const {
    const Hdf5Library::Dataset dataset = file_.dataset(path);
    Message answer = good();
    answer.put(std::uint64_t{dataset.sizes().size()});
    for (const std::uint64_t size : dataset.sizes()) answer.put(size);
    wire_.send(answer);
    if (wire_.receive(sizeof(std::uint64_t)).take_number() != 1) return;
    // There is no way to complain between two values.
    if (!dataset.read([this](std::span<const double> values) { wire_.send(values); }))
      throw WireBroken("the values cannot be read");
  }

  void say_list(const std::vector<std::string>& texts) const {
    Message answer = good();
    answer.put(std::uint64_t{texts.size()});
    for (const std::string& text : texts) answer.put(text);
    wire_.send(answer);
  }

  void say_text(const std::optional<std::string>& text) const {
    Message answer = good();
    answer.put(std::uint64_t{text.has_value()});
    if (text) answer.put(*text);
    wire_.send(answer);
  }

  void say_values(const std::optional<std::vector<double>>& values) const {
    Message answer = good();
    answer.put(std::uint64_t{values.has_value()});
    if (values) answer.put(std::uint64_t{values->size()});
    wire_.send(answer);
    if (values) wire_.send(*values);
  }

  const Hdf5Library& file_;
  const Wire& wire_;
};

void complain(const Wire& wire, const std::string& reason) {
  Message answer;
  answer.put(std::uint64_t{0});
  answer.put(reason);
  wire.send(answer);
}

}  // namespace

Message question_about(Hdf5Question question, const std::string& path, const std::string& name, std::uint64_t most) {
  Message message;
  message.put(static_cast<std::uint64_t>(question));
  message.put(path);
  message.put(name);
  message.put(most);
  return message;
}

namespace {

void answer_questions(const std::string& file, const Wire& wire, void (*once_open)()) {
  constexpr std::size_t longest_question = 1 << 20;
  try {
    const Hdf5Library library(file);
    if (once_open != nullptr) once_open();
    Message opened;
    opened.put(std::uint64_t{library.is_open()});
    wire.send(opened);
    const Hdf5Server server(library, wire);
    while (library.is_open()) {
      Message question = wire.receive(longest_question);
      try {
        server.answer(std::move(question));
      } catch (const Hdf5Error& error) {
        complain(wire, error.what());
      }
    }
  } catch (const WireBroken&) {  // nobody asks any more
  }
}

}  // namespace

void answer_questions(const std::string& file, const Wire& wire) { answer_questions(file, wire, nullptr); }

void serve_file(const std::string& file, int socket) {
  keep_out_of_other_files();
  answer_questions(file, Wire(socket), open_no_more_files);
}

}  // namespace balance
