#include "pipeline/farm/tasks.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "core/foundation/base/error.h"
#include "core/foundation/base/process.h"
#include "pipeline/graph.h"

namespace vitrine {

namespace {

constexpr const char* kHeader = "index\tcapture\tphotos\tcores\tmemory_mib\thours\tfolder\tproject\toptions, a column each";
constexpr size_t kColumns = 8;  // before the options
constexpr double kMiB = 1 << 20;

// Tabs and line ends would end a cell.
void check_cell(const std::string& text) {
  if (text.find_first_of("\t\n\r") != std::string::npos)
    throw Error(ErrorKind::Input, "a name has a tab or a line end in it",
                {.where = text, .hint = "rename the folder", .code = "BAD_NAME"});
}

std::vector<std::string> cells(const std::string& line, char separator) {
  std::vector<std::string> out(1);
  for (const char c : line) {
    if (c == separator)
      out.emplace_back();
    else
      out.back() += c;
  }
  return out;
}

template <class T>
std::optional<T> number(const std::string& text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

struct ArrayVariable {
  const char *name, *engine;
  size_t first;
};
constexpr std::array kArrayVariables{ArrayVariable{"SLURM_ARRAY_TASK_ID", "Slurm", 1},
                                     ArrayVariable{"SGE_TASK_ID", "Grid Engine", 1},
                                     ArrayVariable{"PBS_ARRAY_INDEX", "PBS", 1},
                                     ArrayVariable{"LSB_JOBINDEX", "LSF", 1},
                                     ArrayVariable{"AWS_BATCH_JOB_ARRAY_INDEX", "AWS Batch", 0},
                                     ArrayVariable{"JOB_COMPLETION_INDEX", "Kubernetes", 0},
                                     ArrayVariable{"PARALLEL_SEQ", "GNU parallel", 1}};

size_t number_of_variable(const char* name) {
  const char* text = std::getenv(name);
  return text == nullptr ? 0 : number<size_t>(text).value_or(0);
}

}  // namespace

Words run_words(const FarmTask& task) {
  Words words{(own_folder() / "vitrine").string(), "run", task.photos.string(), "-o", task.project.string()};
  words.insert(words.end(), task.options.begin(), task.options.end());
  words.insert(words.end(), {"--threads", std::to_string(task.cores), "--no-progress"});
  if (task.memory_bytes > 0)
    words.insert(words.end(), {"--max-memory", fmt::format("{}MiB", size_t(std::ceil(double(task.memory_bytes) / kMiB)))});
  return words;
}

fs::path tasks_path(const fs::path& results) { return results / "tasks.tsv"; }

void write_tasks(const fs::path& results, const std::vector<FarmTask>& tasks) {
  std::string table = std::string(kHeader) + "\n", commands;
  for (size_t i = 0; i < tasks.size(); ++i) {
    const FarmTask& t = tasks[i];
    for (const std::string& text : {t.capture, t.photos.string(), t.project.string()}) check_cell(text);
    for (const std::string& word : t.options) check_cell(word);
    table += fmt::format("{}\t{}\t{}\t{}\t{}\t{:.2f}\t{}\t{}", i + 1, t.capture, t.photo_count, t.cores,
                         size_t(std::ceil(double(t.memory_bytes) / kMiB)), t.hours, t.photos.string(), t.project.string());
    for (const std::string& word : t.options) table += "\t" + word;
    table += "\n";
    commands += join_command(run_words(t)) + "\n";
  }
  make_folders(results);
  write_file(results / "tasks.txt", commands);
  write_file(tasks_path(results), table);
}

std::vector<FarmTask> read_tasks(const fs::path& results) {
  const fs::path path = tasks_path(results);
  std::error_code ec;
  if (!fs::exists(path, ec))
    throw Error(ErrorKind::Input, "there is no plan",
                {.where = path.string(), .hint = "vitrine farm plan CAPTURES -o RESULTS writes it", .code = "NO_PLAN"});
  std::vector<std::string> lines = cells(read_file(path), '\n');
  const auto fail = [&](size_t line, const std::string& why) {
    return Error(ErrorKind::Input, "the plan cannot be read",
                 {.where = fmt::format("{}:{}", path.string(), line + 1), .why = why, .hint = "plan again", .code = "BAD_PLAN"});
  };
  if (lines[0] != kHeader) throw fail(0, "its header is another one");
  std::vector<FarmTask> tasks;
  for (size_t i = 1; i < lines.size(); ++i) {
    if (lines[i].empty()) continue;
    const std::vector<std::string> row = cells(lines[i], '\t');
    if (row.size() < kColumns) throw fail(i, fmt::format("{} columns for at least {}", row.size(), kColumns));
    const auto photos = number<size_t>(row[2]), memory = number<size_t>(row[4]);
    const auto cores = number<int>(row[3]);
    const auto hours = number<double>(row[5]);
    if (!photos || !memory || !cores || !hours || *cores < 1) throw fail(i, "a count is no number");
    FarmTask t{.capture = row[1],
               .photos = row[6],
               .project = row[7],
               .photo_count = *photos,
               .cores = *cores,
               .memory_bytes = *memory << 20,
               .hours = *hours};
    t.options.assign(row.begin() + kColumns, row.end());
    tasks.push_back(std::move(t));
  }
  if (tasks.empty()) throw fail(0, "it has no tasks");
  return tasks;
}

size_t array_index() {
  std::optional<size_t> index;
  std::string from, names;
  for (const ArrayVariable& v : kArrayVariables) {
    names += fmt::format("{}{} ({})", names.empty() ? "" : ", ", v.name, v.engine);
    const char* text = std::getenv(v.name);
    const auto value = text == nullptr ? std::nullopt : number<size_t>(text);
    if (!value || *value < v.first) continue;  // outside an array: "undefined" of Grid Engine, 0 of LSF
    if (index && *index != *value - v.first)
      throw Error(ErrorKind::Usage, "two engines give this task a number",
                  {.why = fmt::format("{} and {}", from, v.name), .hint = "give the number: --index N", .code = "USAGE"});
    index = *value - v.first, from = v.name;
  }
  if (!index)
    throw Error(
        ErrorKind::Usage, "no engine gives this task a number",
        {.why = "none of these variables is set: " + names, .hint = "give the number: --index N, from 1", .code = "USAGE"});
  return *index;
}

int given_cores() {
  for (const char* name : {"SLURM_CPUS_PER_TASK", "NSLOTS", "LSB_DJOB_NUMPROC"})
    if (const size_t n = number_of_variable(name); n > 0) return int(n);
  return 0;
}

size_t given_memory() { return number_of_variable("SLURM_MEM_PER_NODE") << 20; }

}  // namespace vitrine
