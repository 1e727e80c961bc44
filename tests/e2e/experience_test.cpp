// What users are promised, where no other test looks (README.md has the whole list): little memory, no display, no network;
// camera files that say the same; records that obey their schema.
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>

#include <cstddef>

#include "tests/e2e/tiny_room.h"
#include "tests/support/json_schema.h"

namespace vitrine {
namespace {

// Kills this process, and what it starts, when it opens a socket of any network.
bool forbid_network() {
  sock_filter rules[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_socket, 0, 3),
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, args[0])),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, AF_UNIX, 1, 0),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  const sock_fprog program{.len = static_cast<unsigned short>(std::size(rules)), .filter = rules};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

class Experience : public TinyRoom {
 protected:
  // A run in a small world: no display, no network, 2 GiB of address space, which is more than resident memory.
  int confined(const std::vector<std::string>& arguments) const {
    const std::vector<std::string> all = words(arguments);
    const pid_t child = fork();
    if (child == 0) {
      const rlimit two_gib{.rlim_cur = size_t{2} << 30, .rlim_max = size_t{2} << 30};
      for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY", "XDG_RUNTIME_DIR", "TERM"}) unsetenv(name);
      std::vector<char*> argv;
      for (const std::string& w : all) argv.push_back(const_cast<char*>(w.c_str()));
      argv.push_back(nullptr);
      if (setrlimit(RLIMIT_AS, &two_gib) == 0 && forbid_network()) execv(argv[0], argv.data());
      _exit(99);
    }
    return wait_for(child);
  }
};

TEST_F(Experience, NeedsNeitherDisplayNorNetworkNorMuchMemory) {
  for (const auto& e : fs::directory_iterator(photos())) fs::permissions(e.path(), fs::perms::owner_read);
  EXPECT_EQ(confined({"run", photos().string(), "-o", out().string(), "--poses", true_poses(), "--preset", "preview", "-j", "1",
                      "--set", "optimize.iterations=60", "--set", "optimize.max_gaussians=3000", "--set", "mesh.resolution=32",
                      "--set", "mesh.faces=4000", "-q"}),
            0);
  for (const char* file : {"report.html", "mesh/mesh.ply", "gaussians/diffuse.ply", "eval/metrics.json", "export"})
    EXPECT_TRUE(fs::exists(out() / file)) << file;
  // COLMAP, too: it finds too little in pictures of 96 x 64, and that is its answer.
  EXPECT_EQ(confined({"run", photos().string(), "-o", (folder.path() / "poses").string(), "-j", "1", "--to", "sfm", "--set",
                      "sfm.retries=0", "-q"}),
            4);
}

TEST_F(Experience, RecordsOfTheRealStagesObeyTheSchema) {
  ASSERT_EQ(
      room(true_poses(), {"--to", "optimize", "--set", "optimize.iterations=20", "--set", "optimize.checkpoint_every=5"}).exit,
      0);
  const auto schema = nlohmann::json::parse(read_file(fs::path(VITRINE_SOURCE_DIR) / "configs/events.schema.json"));
  std::istringstream lines(read_file(out() / "events.jsonl"));
  std::set<std::string> seen;
  for (std::string line; std::getline(lines, line);) {
    const auto event = nlohmann::json::parse(line);
    EXPECT_EQ(test::schema_complaint(event, schema), "") << line;
    seen.insert(event.at("type"));
  }
  for (const char* type : {"plan", "progress", "checkpoint", "metric", "timing", "artifact", "stage_end"})
    EXPECT_TRUE(seen.contains(type)) << type;
}

// Both files read by a few lines that share nothing with the program's own readers.
TEST_F(Experience, SparseModelAndTransformsDescribeTheSameCameras) {
  ASSERT_EQ(room(true_poses(), {"--to", "sfm"}).exit, 0);
  struct Pose {
    double rotation[3][3], centre[3];
    int camera;
  };
  std::map<std::string, Pose> poses;
  std::map<int, std::vector<double>> cameras;  // width height fx fy cx cy
  const auto data_lines = [&](const char* file) {
    std::vector<std::string> lines;
    std::istringstream in(read_file(out() / "sparse/0" / file));
    for (std::string line; std::getline(in, line);)
      if (!line.starts_with("#")) lines.push_back(line);
    return lines;
  };
  for (const std::string& line : data_lines("cameras.txt")) {
    std::istringstream in(line);
    int id = 0;
    std::string model;
    in >> id >> model;
    ASSERT_EQ(model, "PINHOLE");
    for (double v; in >> v;) cameras[id].push_back(v);
  }
  const std::vector<std::string> images = data_lines("images.txt");
  for (size_t i = 0; i < images.size(); i += 2) {  // every second line lists the points of the image above it
    std::istringstream in(images[i]);
    int id = 0, camera = 0;
    double w, x, y, z, t[3];
    std::string name;
    in >> id >> w >> x >> y >> z >> t[0] >> t[1] >> t[2] >> camera >> name;
    Pose p{.rotation = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                        {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                        {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}},
           .centre = {},
           .camera = camera};
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) p.centre[c] -= p.rotation[r][c] * t[r];
    poses[name] = p;
  }
  const auto transforms = json("transforms.json");
  ASSERT_EQ(transforms.at("frames").size(), poses.size());
  ASSERT_EQ(poses.size(), 12u);
  for (const auto& frame : transforms.at("frames")) {
    const std::string name = fs::path(frame.at("file_path").get<std::string>()).filename().string();
    ASSERT_TRUE(poses.contains(name)) << name;
    const Pose& p = poses[name];
    const auto& m = frame.at("transform_matrix");
    for (int r = 0; r < 3; ++r) {
      EXPECT_NEAR(m[r][3], p.centre[r], 1e-6) << name;
      // world from camera, x right, y up, z backwards: the columns are the rows of camera from world, two of them turned round
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(m[r][c], (c == 0 ? 1 : -1) * p.rotation[c][r], 1e-6) << name;
    }
    const std::vector<double>& k = cameras.at(p.camera);
    const char* names[] = {"w", "h", "fl_x", "fl_y", "cx", "cy"};
    for (size_t i = 0; i < 6; ++i)
      EXPECT_NEAR((frame.contains(names[i]) ? frame : transforms).at(names[i]).get<double>(), k[i], 1e-6) << names[i];
  }
}

}  // namespace
}  // namespace vitrine
