import {buildPage} from "./page.js";
import {PlanarStage} from "./motion/planar_stage.js";

buildPage(PlanarStage);
