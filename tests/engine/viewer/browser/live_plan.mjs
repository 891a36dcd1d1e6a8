// A short plan for people with a mouse, for tests with the real program.

import { writeFileSync } from "node:fs";
import { join } from "node:path";

import { kProject } from "./chromium.mjs";

const kTexts = { information: "Read this.", consent: "I agree.", instructions: "Touch <b>it</b>.", debriefing: "Thank you." };

// Returns the path of the plan. live, changes: keys of `live` and of the plan that differ from this one.
export function writeLivePlan(folder, { live, ...changes } = {}) {
  const path = join(folder, "plan.json");
  writeFileSync(path, JSON.stringify({
    palpate_plan: 1, name: "short", seed: 7, participants: 3, blocks: 1, practice_blocks: 1,
    device: { sensors: 2, actuators: 1, rate_Hz: 1000, stiffness_N_per_m: 1000, damping_Ns_per_m: 2 },
    display_Hz: 40, sphere_radius_m: 0.006, limit_s: 120, haptic: ["NoH"], rotation: ["NoR"],
    objects: { O1: join(kProject, "models/star.glb") }, operator: "people2005", followings: ["delayed"],
    live: { input: "mouse", texts: kTexts, break_s: 0, longest_picture_s: 10, longest_lateness_s: 10, ...live },
    ...changes,
  }));
  return path;
}
