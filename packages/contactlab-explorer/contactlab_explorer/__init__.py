"""The page of `contactlab explore`: laws under sliders, in the browser."""
