// Files that a window writes of what it shows, in the background: a picture, or a model.
#pragma once

#include "viewer/background_work.h"
#include "viewer/viewer.h"

#include <functional>
#include <string>

namespace proxima {

class ViewFiles {
public:
    /// `wake` is called by a thread that has written a file.
    explicit ViewFiles(std::function<void()> wake) : wake_(std::move(wake)) {}

    /// Begin to write what the viewer shows now: as a PNG of that size, as .glb. Nothing while
    /// another file is written.
    void write_picture(const Viewer& viewer, ViewSize size, std::string path);
    void write_model(const Viewer& viewer, std::string path);

    [[nodiscard]] bool is_busy() const noexcept { return writing_.is_busy(); }
    /// Takes what is finished. True where there is news.
    bool follow();
    /// Waits for the file that is being written. Error: it could not be.
    [[nodiscard]] Status finish();
    /// A message about the file being written, or the last one; empty before the first.
    [[nodiscard]] const std::string& news() const noexcept { return news_; }
    /// Why the last file could not be written; empty if it was.
    [[nodiscard]] const std::string& problem() const noexcept { return problem_; }
    /// Removes the messages, since a person has read them. A file that is still being written makes
    /// a new one.
    void forget_news();

private:
    void begin(std::string path);

    std::function<void()> wake_;
    std::string path_;
    std::string news_;
    std::string problem_;
    BackgroundWork<Status> writing_;
};

} // namespace proxima
