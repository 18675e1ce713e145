/* Charts: beamvizChart.draw(element, data). */
window.beamvizChart = { draw(element, data) {} };
