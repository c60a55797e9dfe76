/** Asks for the first picture while the rest of the page is still on its way. */

import { begin } from "./api.js";
import { Fields, firstExample } from "./form.js";
import { curvesOf, tableOf } from "./questions.js";
import { stateOf } from "./state.js";

const state = stateOf(location.hash) ?? firstExample();
if (Fields.faultsOf(state).length === 0) [tableOf(state), curvesOf(state)].forEach(([path, question]) => begin(path, question));
