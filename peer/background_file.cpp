#include "peer/background_file.h"

namespace padr::peer {

BackgroundFile::BackgroundFile(std::string_view flag, const std::string& path, std::chrono::milliseconds interval,
                               std::size_t most)
    : file_(flag, path, shell::Readers::kAsUsual, shell::Content::kBinary),
      interval_(interval),
      room_(most),
      thread_([this] { write_on(); }) {}

BackgroundFile::~BackgroundFile() {
  end_thread();
}

bool BackgroundFile::append(std::span<const std::byte> bytes) {
  const std::lock_guard lock(mutex_);
  if (!failure_.empty() || bytes.size() > room_) return false;
  room_ -= bytes.size();
  waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
  return true;
}

std::string BackgroundFile::failure() {
  const std::lock_guard lock(mutex_);
  return failure_;
}

void BackgroundFile::end_thread() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
}

void BackgroundFile::close() {
  end_thread();
  if (trouble_) std::rethrow_exception(trouble_);
  file_.close();
}

void BackgroundFile::write_on() {
  std::vector<std::byte> writing;
  std::string failure;
  for (bool last = false; !last;) {
    {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, interval_, [this] { return closing_; });
      last = closing_;
      writing.swap(waiting_);
    }
    try {
      if (!trouble_ && !writing.empty()) {
        file_.write(writing);
        file_.flush();
      }
    } catch (const std::exception& e) {
      trouble_ = std::current_exception();  // read once the thread has ended
      failure = e.what();
    }
    const std::lock_guard lock(mutex_);
    failure_ = failure;
    room_ += writing.size();
    writing.clear();
  }
}

}  // namespace padr::peer
