// A program that edits a solved scene: moves a box about and prints what a place on it sends on.
//
//   edit_scene SCENE.json NAME      a manifest, and one of its instances
//
// Built with the tests; programs of your own link rro::solver (samples/programs/CMakeLists.txt).
#include <cstdio>

#include "solver/session.h"

int main(int count, char** words) {
    if (count != 3) {
        std::fprintf(stderr, "usage: edit_scene SCENE.json NAME\n");
        return 2;
    }
    const char* name = words[2];
    const auto report = [](const rro::Error& error) {
        std::fprintf(stderr, "edit_scene: %s: %s\n", error.where.c_str(), error.message.c_str());
        return 1;
    };

    auto session = rro::SceneSession::open(words[1]);
    if (!session) return report(session.error());
    if (const auto solved = session->solve(); !solved) return report(solved.error());

    rro::Affine3 place;
    for (const rro::Instance& instance : session->scene().instances)
        if (instance.name == name) place = instance.to_world;
    for (int step = 0; step < 4; ++step) {
        place.translation.x += 0.1;  // metres
        if (const auto moved = session->move(name, place); !moved) return report(moved.error());
        const auto solved = session->solve();
        if (!solved) return report(solved.error());
        const auto light = session->radiosity(name, 0);
        if (!light) return report(light.error());
        std::printf("x = %.2f m: %.4g %.4g %.4g W/m^2, %.0f %% of the links judged again\n", place.translation.x, light->x, light->y,
                    light->z, 100.0 * double(session->change().added + session->change().retested) / double((*solved)->links.total()));
    }
    return 0;
}
